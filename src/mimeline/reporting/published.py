"""What Ma et al. 2025 report of their model and its variants (Table 2)."""

from pathlib import Path

import pandas as pd

from mimeline.vocabulary import resource

TABLE = "paper_ablations.csv"


def published(table: str | Path | None = None) -> dict[tuple[str, str], float]:
    """The paper's values by row and metric; table: our copy of its table."""
    rows = pd.read_csv(table or resource(TABLE)).itertuples()
    return {(row.variant, row.metric): row.value for row in rows}

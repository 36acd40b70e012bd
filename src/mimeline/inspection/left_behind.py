"""What a run left in its results: ledgers and tables, stage by stage."""

from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.errors import NoSuchFile
from mimeline.reporting.funnel import STAGES
from mimeline.tables import Table


def ledgers(results: Path) -> list[Path]:
    """The ledgers of a run, in the order of its stages. Raises NoSuchFile where there is none."""
    found = [path for stage in STAGES for path in _files(results, stage, "ledger")]
    if not found:
        there = Path(results).is_dir()
        raise NoSuchFile(
            results,
            found="no ledger" if there else "no such folder",
            expected="the results of a run: catalogue/ledger.parquet and what follows it",
            remedy="Run snakemake first, or name the results of another run: --results FOLDER.",
        )
    return found


def decisions(results: Path) -> pd.DataFrame:
    """All rows of the ledgers, with the place of the stage in the order of stages."""
    rows = tables.read_all(tables.LEDGER, ledgers(results))
    return rows.assign(place=rows["stage"].map(STAGES.index))


def rows_of(results: Path, stage: str, table: Table, columns: list[str] | None = None):
    """The rows of a stage's table, of all shards; none where the stage has not run."""
    return tables.read_all(table, _files(results, stage, table.name), columns)


def has_run(results: Path, stage: str) -> bool:
    return bool(_files(results, stage, "ledger"))


def shards(results: Path, stage: str) -> list[Path]:
    """The folders of a stage's shards."""
    return [path.parent for path in _files(results, stage, "clips")]


def files_with(results: Path, table: Table, stage: str, clip_id: str) -> list[Path]:
    """The files of a stage's table that hold rows of the clip."""
    return [
        path
        for path in _files(results, stage, table.name)
        if (tables.read(table, path, ["clip_id"])["clip_id"] == clip_id).any()
    ]


def _files(results: Path, stage: str, name: str) -> list[Path]:
    """A stage's tables of a name: its own, and those of its shards."""
    folder = Path(results) / stage
    own = [folder / f"{name}.parquet"]
    return [*filter(Path.is_file, own), *sorted(folder.glob(f"[0-9]*/{name}.parquet"))]

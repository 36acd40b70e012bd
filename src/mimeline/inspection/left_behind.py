"""What a run left in its results: ledgers and tables, stage by stage."""

import sys
from functools import cache
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from mimeline import tables
from mimeline.errors import BadFile, NoSuchFile
from mimeline.reporting.funnel import STAGES
from mimeline.run import recall
from mimeline.tables import Table

ANY = range(sys.maxsize)  # shards


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
    """All rows of the ledgers, with the place of the stage in the order of stages.

    Raises BadFile for a stage that nobody knows: another version of the product wrote the ledger.
    """
    rows = tables.read_all(tables.LEDGER, ledgers(results))
    if unknown := sorted(set(rows["stage"]) - set(STAGES)):
        raise BadFile(
            results,
            place="ledgers",
            found=f"the stage {unknown[0]!r}",
            expected=f"{', '.join(STAGES)}",
            remedy=f"Another version made these results: {recall(results).command()}.",
        )
    return rows.assign(place=rows["stage"].map(STAGES.index))


def rows_of(results: Path, stage: str, table: Table, columns: list[str] | None = None):
    """The rows of a stage's table, of all shards; none where the stage has not run.

    Raises BadFile where a clip stands twice in a table that has a row per clip.
    """
    rows = tables.read_all(table, _files(results, stage, table.name), columns)
    if table.order == ("clip_id",) and (twice := rows["clip_id"].duplicated()).any():
        raise BadFile(
            Path(results) / stage,
            place=f"table {table.name}",
            found=f"clip {rows.loc[twice, 'clip_id'].iloc[0]!r} twice",
            expected="a row per clip",
            remedy="The tables are of different runs: delete the folder and run snakemake again.",
        )
    return rows


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
    of_shards, run = _of_shards(folder, name), _shards_of_run(Path(results))
    return [*filter(Path.is_file, own), *(of_shards[n] for n in sorted(of_shards) if n in run)]


def _of_shards(folder: Path, name: str) -> dict[int, Path]:
    """Number of the shard → its file of that name."""
    paths = folder.glob(f"[0-9]*/{name}.parquet")
    return {int(path.parent.name): path for path in paths if path.parent.name.isdecimal()}


def _shards_of_run(results: Path) -> range:
    """The shards that hold what the catalogue kept; folders beyond are of a run with more."""
    ledger = results / "catalogue" / "ledger.parquet"
    return _holding_all(ledger, ledger.stat().st_mtime_ns) if ledger.is_file() else ANY


@cache
def _holding_all(ledger: Path, _written: int) -> range:
    shards = _of_shards(ledger.parent, "clips")
    try:
        ids = pq.read_table(ledger, columns=["clip_id"], filters=[("status", "=", "kept")])
        kept, held = pc.count_distinct(ids["clip_id"]).as_py(), 0
        for number in sorted(shards):
            held += pq.read_metadata(shards[number]).num_rows
            if held == kept:
                return range(number + 1)
    except (pa.ArrowException, OSError):
        pass  # who reads such a file says what is wrong with it
    return ANY

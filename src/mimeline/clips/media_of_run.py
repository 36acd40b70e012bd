"""Where the films and sounds of a run's clips lie."""

from pathlib import Path

from mimeline import tables

KINDS = {"film": "media", "sound": "audio"}  # of files → the column that names them


def files_of(results: Path, kind: str) -> dict[str, Path]:
    """Clip → its film or sound, of those that are there, wherever the results were moved since."""
    found = {}
    for table in results.glob("fetch/*/clips.parquet"):
        folder = table.with_name("media")
        there = {p.name: p for p in folder.iterdir()} if folder.is_dir() else {}
        named = tables.read(tables.CLIPS, table, ["clip_id", KINDS[kind]]).dropna()
        for clip_id, path in named.itertuples(index=False):
            if (name := Path(path).name) in there:
                found[clip_id] = there[name]
    return found

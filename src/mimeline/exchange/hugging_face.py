"""A run's clips as a data set for the Hugging Face hub: sharded Parquet, a row per clip, a card."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from mimeline.dataset.split import PARTS
from mimeline.exchange import card
from mimeline.exchange.contents import Contents
from mimeline.exchange.features import for_card, with_features
from mimeline.exchange.finished import Finished, Shard
from mimeline.exchange.licences import DataSet, licence_of_all
from mimeline.exchange.release import Release
from mimeline.vocabulary import ACTIONS, UNKNOWN

SPLITS = {"train": "train", "val": "validation", "test": "test"}  # ours → the hub's
ROWS = 64  # in a row group: what a reader takes at once
_CLIP = {
    "clip_id": pa.string(),
    "data_set": pa.string(),
    "source_id": pa.string(),
    "subject_id": pa.string(),
    "group": pa.string(),
    "start_s": pa.float64(),
    "end_s": pa.float64(),
    "fps": pa.float64(),
    "fps_num": pa.int64(),
    "fps_den": pa.int64(),
    "n_frames": pa.int64(),
    "emotion": pa.string(),
    "attributes": pa.list_(pa.string()),
    "texts": pa.list_(pa.string()),
    "descriptions": pa.list_(pa.string()),
}
_TRACKED = {
    "valid": pa.list_(pa.bool_()),
    "confidence": pa.list_(pa.float32()),
    "tracker_loss": pa.list_(pa.float32()),
}
_INTERVAL = pa.struct(
    {
        "track": pa.string(),
        "action": pa.string(),
        "start_frame": pa.int64(),
        "end_frame": pa.int64(),
        "side": pa.string(),
        "source": pa.string(),
        "confidence": pa.float64(),
    }
)


def write(
    folder: Path, run: Finished, sets: Sequence[DataSet], contact: str, max_bytes: int
) -> Release:
    """Write the data set into an empty folder.

    sets: what the clips are of. max_bytes: after which a Parquet file ends and another begins, in
    memory; the files are smaller. A part without a clip has no file: `datasets` stop at a split
    without a row.
    """
    columns = schema(run.measured)
    parts = {name: _Files(folder / "data", SPLITS[name], columns, max_bytes) for name in PARTS}
    contents = Contents()
    of = {clip_id: own.name for own in sets for clip_id in own.clips}
    for shard in run.shards():
        contents.add(shard)
        rows = rows_of(shard, columns, of, run.descriptions)
        for name, files in parts.items():
            files.write(rows.filter(pa.array(shard.clips["part"] == name)))
    for files in parts.values():
        files.close()
    filled = [files for files in parts.values() if files.rows]
    release = Release(run, tuple(sets), contact, contents, run.measured)
    release.write_tables(folder)
    front = _front_matter(release, columns, filled)
    card.write(folder / "README.md", "hugging_face.md.j2", release, front, splits=SPLITS)
    return release


def schema(channels: Sequence[str]) -> pa.Schema:
    """The columns of a row. channels: those of `motion`."""
    motion = pa.struct({name: pa.list_(pa.float32()) for name in channels})
    actions = pa.struct({name: pa.list_(pa.int8()) for name in ACTIONS})
    columns = {**_CLIP, **_TRACKED, "motion": motion, "actions": actions}
    return with_features(pa.schema({**columns, "intervals": pa.list_(_INTERVAL)}))


def rows_of(
    shard: Shard, columns: pa.Schema, of: dict[str, str], descriptions: dict[str, list[str]]
) -> pa.Table:
    """A row for each clip of a shard. of: clip → its data set."""
    clips, motion, frames = shard.clips, shard.motion, shard.frames
    clips = clips.assign(
        data_set=clips["clip_id"].map(of),
        fps=clips["fps_num"].astype(float) / clips["fps_den"].astype(float),
        descriptions=[descriptions.get(clip_id, []) for clip_id in clips["clip_id"]],
    )
    known = {name: pa.array(clips[name], kind, from_pandas=True) for name, kind in _CLIP.items()}
    ends = np.cumsum(clips["n_frames"].to_numpy(np.int64))
    offsets = pa.array(np.concatenate([[0], ends]), pa.int32())

    def listed(values: np.ndarray, kind: pa.ListType) -> pa.ListArray:
        return pa.ListArray.from_arrays(offsets, pa.array(values, kind.value_type), type=kind)

    def by_name(column: str, values: Callable[[str], np.ndarray]) -> pa.StructArray:
        kinds = list(columns.field(column).type)
        arrays = [listed(values(kind.name), kind.type) for kind in kinds]
        return pa.StructArray.from_arrays(arrays, fields=kinds)

    def shown(action: str) -> np.ndarray:
        return frames[action].to_numpy(np.float32, na_value=UNKNOWN).astype(np.int8)

    tracked = {
        name: listed(motion[name].to_numpy(bool if name == "valid" else np.float32), kind)
        for name, kind in _TRACKED.items()
    }
    arrays = {
        **known,
        **tracked,
        "motion": by_name("motion", lambda name: motion[name].to_numpy(np.float32)),
        "actions": by_name("actions", shown),
        "intervals": _intervals(shard, columns.field("intervals").type),
    }
    return pa.table(arrays, schema=columns)


def _intervals(shard: Shard, kind: pa.ListType) -> pa.ListArray:
    """Each clip's intervals, as their table sorts them."""
    ids = shard.clips["clip_id"]
    n = shard.intervals.groupby("clip_id").size().reindex(ids, fill_value=0)
    ends = np.cumsum(n.to_numpy(np.int64))
    told = [pa.array(shard.intervals[f.name], f.type, from_pandas=True) for f in kind.value_type]
    values = pa.StructArray.from_arrays(told, fields=list(kind.value_type))
    offsets = pa.array(np.concatenate([[0], ends]), pa.int32())
    return pa.ListArray.from_arrays(offsets, values, type=kind)


@dataclass
class _Files:
    """The Parquet files of a split, which are numbered once it is known how many there are."""

    folder: Path
    split: str
    columns: pa.Schema
    max_bytes: int
    paths: list[Path] = field(default_factory=list)
    rows: int = 0
    bytes: int = 0  # in memory, as `datasets` counts them
    _writer: pq.ParquetWriter | None = None
    _filled: int = 0

    def write(self, rows: pa.Table) -> None:
        for group in _groups(rows):
            if self._writer is None or self._filled >= self.max_bytes:
                self._next()
            self._writer.write_table(group)
            self._filled += group.nbytes
            self.rows, self.bytes = self.rows + len(group), self.bytes + group.nbytes

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()
        for number, path in enumerate(self.paths):
            name = f"{self.split}-{number:05d}-of-{len(self.paths):05d}.parquet"
            self.paths[number] = path.replace(self.folder / name)

    def _next(self) -> None:
        if self._writer is not None:
            self._writer.close()
        self.folder.mkdir(exist_ok=True)
        self.paths.append(self.folder / f"{self.split}-{len(self.paths):05d}.tmp")
        leaves = [leaf for column in self.columns for leaf in _leaves(column.name, column.type)]
        self._writer = pq.ParquetWriter(
            self.paths[-1],
            self.columns,
            compression="zstd",
            use_dictionary=[leaf for leaf in leaves if not leaf.startswith("motion.")],
            use_byte_stream_split=[leaf for leaf in leaves if leaf.startswith("motion.")],
        )  # which makes motion a third smaller
        self._filled = 0


def _leaves(name: str, kind: pa.DataType) -> Iterator[str]:
    """The paths of Parquet's own columns that a column becomes."""
    if pa.types.is_list(kind):
        yield from _leaves(f"{name}.list.element", kind.value_type)
    elif pa.types.is_struct(kind):
        for own in kind:
            yield from _leaves(f"{name}.{own.name}", own.type)
    else:
        yield name


def _groups(rows: pa.Table) -> Iterator[pa.Table]:
    for start in range(0, len(rows), ROWS):
        yield rows.slice(start, ROWS)


def _front_matter(release: Release, columns: pa.Schema, parts: Sequence[_Files]) -> dict[str, Any]:
    """What the hub reads of a card."""
    licence = licence_of_all(release.sets)
    stored = [path.stat().st_size for files in parts for path in files.paths]
    front: dict[str, Any] = {"pretty_name": release.title, "license": licence}
    if licence == "other":
        pages = {own.page for own in release.sets}
        front |= {"license_name": "see-the-card"}
        front |= {"license_link": pages.pop()} if len(pages) == 1 and all(pages) else {}
    return front | {
        "language": ["en"],
        "task_categories": ["other"],
        "tags": ["facial-animation", "blendshapes", "arkit", "motion-generation", "timeline"],
        "size_categories": [_size(sum(files.rows for files in parts))],
        "configs": [
            {
                "config_name": "default",
                "data_files": [
                    {"split": files.split, "path": f"data/{files.split}-*"} for files in parts
                ],
            }
        ],
        "dataset_info": {
            "features": for_card(columns),
            "splits": [
                {"name": files.split, "num_bytes": files.bytes, "num_examples": files.rows}
                for files in parts
            ],
            "download_size": sum(stored),
            "dataset_size": sum(files.bytes for files in parts),
        },
    }


def _size(rows: int) -> str:
    """The hub's word for how many rows there are."""
    limits = {10**3: "1K", 10**4: "10K", 10**5: "100K", 10**6: "1M", 10**7: "10M"}
    below = "n<1K"
    for limit, name in limits.items():
        if rows < limit:
            break
        above = limits.get(limit * 10, "100M")
        below = f"{name}<n<{above}"
    return below

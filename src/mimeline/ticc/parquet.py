"""Frames in Parquet files, of which a row group is held at a time."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

log = logging.getLogger(__name__)


class ParquetFrames:
    """A source of frames for TICC: the rows of Parquet files, end to end.

    channels: the columns of numbers, in order. sequence, frame: the columns that say which sequence
    a row belongs to and where in it; a sequence ends where the one changes, where the other does
    not go up by one, and with its file. Rows without a sequence (separators) are left out.
    Raises ValueError with the file for what is no Parquet file, lacks a column of numbers or holds
    no frame.
    """

    def __init__(self, paths: Sequence[Path], channels: Sequence[str], sequence: str, frame: str):
        self.channels = list(channels)
        self._groups = []  # (path, row group, whether all its rows are frames)
        sizes, starts, total = [], [], 0
        self._footers = {}
        for path in [paths] if isinstance(paths, str | Path) else paths:
            last = None  # a file begins a sequence
            self._footers[Path(path)] = footer = _footer(path, self.channels, sequence, frame)
            for group, keys in _groups(path, footer, [sequence, frame]):
                kept = keys.filter(keys[sequence].is_valid())
                if not len(kept):
                    continue
                begins, last = _begins(kept[sequence], kept[frame].to_numpy(), last)
                starts.append(np.flatnonzero(begins) + total)
                sizes.append(len(kept))
                total += len(kept)
                self._groups.append((Path(path), group, len(kept) == len(keys)))
        if not total:
            raise ValueError(f"{', '.join(map(str, paths)) or 'no file'}: found no frames")
        self.lengths = np.diff([*np.concatenate(starts), total])
        if np.median(self.lengths) == 1 < total:
            log.warning(
                "most sequences are of one row: does %r go up by one from row to row?", frame
            )
        self.n_channels = len(self.channels)
        self._ends = np.cumsum(sizes)
        self._sequence, self._held = sequence, (-1, None)

    def read(self, begin, end):
        if begin == end:
            return np.empty((0, self.n_channels))
        first, last = np.searchsorted(self._ends, [begin, end - 1], side="right")
        parts = []
        for index in range(first, last + 1):
            offset = self._ends[index - 1] if index else 0
            parts.append(self._values(index)[max(begin - offset, 0) : end - offset])
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _values(self, index: int) -> np.ndarray:
        if self._held[0] != index:
            path, group, whole = self._groups[index]
            needed = self.channels if whole else [self._sequence, *self.channels]
            with pq.ParquetFile(path, metadata=self._footers[path]) as file:
                rows = file.read_row_group(group, columns=needed, use_threads=False)
            if not whole:
                rows = rows.filter(rows[self._sequence].is_valid())
            columns = [rows[name].to_numpy() for name in self.channels]
            self._held = index, np.stack(columns, axis=1)
        return self._held[1]


def _footer(path, channels, sequence, frame) -> pq.FileMetaData:
    try:
        footer = pq.read_metadata(path)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{path}: {error}") from error
    schema = footer.schema.to_arrow_schema()
    if not channels:
        raise ValueError("channels: found none, expected names of columns")
    for name in (sequence, frame, *channels):
        if name not in schema.names:
            raise ValueError(f"{path}: found no column {name!r}, expected one")
        kind = schema.field(name).type
        if name in channels and not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
            raise ValueError(f"{path}, column {name!r}: found {kind}, expected numbers")
    return footer


def _groups(path, footer: pq.FileMetaData, columns: list[str]):
    try:
        with pq.ParquetFile(path, metadata=footer) as file:
            for group in range(file.num_row_groups):
                yield group, file.read_row_group(group, columns=columns)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{path}: {error}") from error


def _begins(sequence: pa.ChunkedArray, frame: np.ndarray, last):
    """Where a sequence begins (rows,) bool, and the (sequence, frame) to compare the next with."""
    codes = sequence.combine_chunks().dictionary_encode().indices.to_numpy()
    begins = np.ones(len(frame), dtype=bool)
    begins[1:] = (np.diff(codes) != 0) | (np.diff(frame) != 1)
    if last is not None:
        begins[0] = (sequence[0].as_py(), frame[0]) != (last[0], last[1] + 1)
    return begins, (sequence[-1].as_py(), frame[-1])

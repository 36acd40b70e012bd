"""Sheets of pictures of an exemplar, frame by frame: filmed, and drawn on a face."""

import threading
from collections.abc import Callable, Iterable
from functools import cached_property
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.media.frames import read_frames
from mimeline.reporting.album import FREE, square
from mimeline.reporting.stand_in import GROUND, stand_in
from mimeline.studio.clusters_of_run import ClustersOfRun, Exemplar
from mimeline.studio.sheets import MOST_BYTES, Order, Sheets, Tiles
from mimeline.vocabulary import CHANNELS

EDGE = 160  # pixels of a picture
COLUMNS = 12  # of a sheet

Key = tuple[str, str, int, int]  # view, region, cluster, rank


class Pictures:
    """The sheets of a run's exemplars. face: as report.face."""

    def __init__(self, run: ClustersOfRun, face: str | Path | None, most_bytes: int = MOST_BYTES):
        self.run, self.face = run, face
        self._makers: dict[str, Callable[[Exemplar], Tiles]] = {
            "film": self._filmed,
            "face": self._drawn,
        }
        self._exemplars = {(e.region, e.cluster, e.rank): e for e in run.exemplars()}
        self._sheets = Sheets[Key](self._order, EDGE, COLUMNS, most_bytes)
        self._load = threading.Lock()

    def sheet(
        self, view: str, region: str, cluster: int, rank: int, at_once: bool = True
    ) -> bytes | None:
        """As `Sheets.get`; None also where there is no such exemplar or view."""
        exemplar = self._exemplars.get((region, cluster, rank))
        if exemplar is None or view not in exemplar.views:
            return None
        return self._sheets.get((view, region, cluster, rank), at_once)

    def expect(self, exemplars: Iterable[Exemplar]) -> None:
        """Make their sheets in the background, in that order, instead of what was expected."""
        self._sheets.expect([(v, e.region, e.cluster, e.rank) for e in exemplars for v in e.views])

    def end(self) -> None:
        """Stop; returns when none is being made, and none will be."""
        self._sheets.end()

    def is_made(self, key: Key) -> bool:
        return self._sheets.is_made(key)

    def _order(self, key: Key) -> Order:
        view, exemplar = key[0], self._exemplars[key[1:]]
        ground = FREE if view == "film" else GROUND
        tiles = self._makers[view](exemplar)
        return Order(exemplar.frames, tiles, ground, f"{view} of {exemplar.clip_id}")

    def _filmed(self, exemplar: Exemplar) -> Tiles:
        for number, frame in read_frames(self.run.films[exemplar.clip_id], exemplar.frames):
            yield number, square(frame, EDGE)

    def _drawn(self, exemplar: Exemplar) -> Tiles:
        with self._load:
            rows, actor = self._motion.get(exemplar.clip_id), self._actor
        if rows is None:
            return
        rows = rows[rows["frame"].isin(exemplar.frames)]
        drawn = actor.pictures(rows, EDGE, region=exemplar.region)
        yield from zip(rows["frame"].tolist(), drawn, strict=True)

    @cached_property
    def _actor(self):
        return stand_in(self.face)

    @cached_property
    def _motion(self) -> dict[str, pd.DataFrame]:
        """Rows of the `motion` tables by clip, of the frames that a sheet shows."""
        shown = {(e.clip_id, frame) for e in self.run.exemplars() for frame in e.frames}
        wanted = pd.DataFrame(shown, columns=["clip_id", "frame"])
        columns = ["clip_id", "frame", "valid", *CHANNELS]
        clips, parts = wanted["clip_id"].unique(), []
        for path in self.run.motions:
            rows = tables.read(tables.MOTION, path, columns, clips)
            parts.append(rows[rows["valid"]].merge(wanted, on=["clip_id", "frame"]))
        rows = pd.concat(parts).sort_values(["clip_id", "frame"])
        return dict(iter(rows.groupby("clip_id")))

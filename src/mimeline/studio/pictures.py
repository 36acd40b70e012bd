"""Sheets of pictures of an exemplar, frame by frame: filmed, and drawn on a face.

One image per exemplar and view plays in step with its curves. Sheets are made when they are asked
for, or shortly before, and kept while there is room.
"""

import logging
import os
import threading
from collections import OrderedDict, defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import MimelineError
from mimeline.media.frames import read_frames
from mimeline.media.picture import encode
from mimeline.reporting.album import FREE, square
from mimeline.reporting.stand_in import GROUND, stand_in
from mimeline.studio.clusters_of_run import ClustersOfRun, Exemplar
from mimeline.vocabulary import CHANNELS

log = logging.getLogger(__name__)

EDGE = 160  # pixels of a picture
COLUMNS = 12  # of a sheet
MOST_BYTES = 128 * 2**20  # of the sheets that are kept

Key = tuple[str, str, int, int]  # view, region, cluster, rank
Tiles = Iterator[tuple[int, np.ndarray]]  # frame, picture (EDGE, EDGE, 3) uint8 RGB


class Pictures:
    """The sheets of a run's exemplars. face: as report.face."""

    def __init__(self, run: ClustersOfRun, face: str | Path | None, most_bytes: int = MOST_BYTES):
        self.run, self.face, self.most_bytes = run, face, most_bytes
        self._makers: dict[str, Callable[[Exemplar], Tiles]] = {
            "film": self._filmed,
            "face": self._drawn,
        }
        self._exemplars = {(e.region, e.cluster, e.rank): e for e in run.exemplars()}
        self._sheets: OrderedDict[Key, bytes] = OrderedDict()  # the one asked for last is last
        self._bytes = 0
        self._wanted: list[Key] = []
        self._making: dict[Key, threading.Lock] = defaultdict(threading.Lock)
        self._lock = threading.Condition()
        self._cores = _Turns(os.cpu_count() or 1)
        self._load = threading.Lock()
        self._ahead: threading.Thread | None = None
        self._ended = False

    def sheet(
        self, view: str, region: str, cluster: int, rank: int, at_once: bool = True
    ) -> bytes | None:
        """A JPEG, the frames of the exemplar left to right, then top to bottom.

        at_once: before all that was asked for earlier; else when nobody waits. None where there is
        no such exemplar or view, or not one of its frames could be shown.
        """
        key = (view, region, cluster, rank)
        exemplar = self._exemplars.get(key[1:])
        if exemplar is None or view not in exemplar.views:
            return None
        with self._lock:
            making = self._making[key]
        with making:  # one thread makes it, others wait for it
            if (kept := self._kept(key)) is None:
                with self._cores.turn(at_once):
                    kept = b"" if self._ended else self._made(view, exemplar)
                if self._ended:
                    return None
                self._keep(key, kept)
        return kept or None

    def expect(self, exemplars: Iterable[Exemplar]) -> None:
        """Make their sheets in the background, in that order, instead of what was expected."""
        wanted = [(view, e.region, e.cluster, e.rank) for e in exemplars for view in e.views]
        with self._lock:
            self._wanted = [key for key in wanted if key not in self._sheets][::-1]
            if self._ahead is None:
                self._ahead = threading.Thread(target=self._work_ahead, daemon=True)
                self._ahead.start()
            self._lock.notify()

    def end(self) -> None:
        """Stop; returns when none is being made, and none will be.

        A thread that is within a decoder when Python ends would bring it down.
        """
        self._ended = True
        self._cores.close()

    def is_made(self, key: Key) -> bool:
        with self._lock:
            return key in self._sheets

    def _work_ahead(self) -> None:
        while True:
            with self._lock:
                self._lock.wait_for(lambda: self._wanted)
                key = self._wanted.pop()
            try:
                self.sheet(*key, at_once=False)
            except Exception:
                log.exception("sheet %s", key)  # whoever asks for it is told

    def _kept(self, key: Key) -> bytes | None:
        with self._lock:
            if key in self._sheets:
                self._sheets.move_to_end(key)
            return self._sheets.get(key)

    def _keep(self, key: Key, sheet: bytes) -> None:
        with self._lock:
            self._sheets[key] = sheet
            self._bytes += len(sheet)
            while self._bytes > self.most_bytes and len(self._sheets) > 1:
                _, gone = self._sheets.popitem(last=False)
                self._bytes -= len(gone)

    def _made(self, view: str, exemplar: Exemplar) -> bytes:
        """The sheet; empty where there is no picture to put on it."""
        places = {frame: place for place, frame in enumerate(exemplar.frames)}
        sheet = np.empty((-(-len(places) // COLUMNS), COLUMNS, EDGE, EDGE, 3), np.uint8)
        sheet[:] = FREE if view == "film" else GROUND
        found = False
        try:
            for frame, picture in self._makers[view](exemplar):
                if self._ended:
                    break
                sheet[divmod(places[frame], COLUMNS)] = picture
                found = True
        except MimelineError as error:  # what came before it is shown
            log.warning("%s of %s: %s", view, exemplar.clip_id, error)
        rows, columns = sheet.shape[:2]
        whole = sheet.swapaxes(1, 2).reshape(rows * EDGE, columns * EDGE, 3)
        return encode(whole, "jpeg") if found else b""

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


class _Turns:
    """Lets a few threads work at a time: who came last first, as a person looks at what they asked
    for last."""

    def __init__(self, n: int):
        self._n, self._free = n, n
        self._waiting: list[object] = []
        self._changed = threading.Condition()

    @contextmanager
    def turn(self, at_once: bool) -> Iterator[None]:
        """at_once: else after everybody who waits."""
        mine = object()
        with self._changed:
            self._waiting.insert(len(self._waiting) if at_once else 0, mine)
            self._changed.wait_for(lambda: self._free and self._waiting[-1] is mine)
            self._waiting.pop()
            self._free -= 1
            self._changed.notify_all()
        try:
            yield
        finally:
            with self._changed:
                self._free += 1
                self._changed.notify_all()

    def close(self) -> None:
        """Returns when nobody works; from then on nobody does."""
        with self._changed:
            self._changed.wait_for(lambda: self._free == self._n)
            self._free = 0

"""Sheets of pictures, frame by frame: one image plays in step with what stands beside it.

Sheets are made when they are asked for, or shortly before, and kept while there is room.
"""

import logging
import os
import threading
from collections import OrderedDict, defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from mimeline.errors import MimelineError
from mimeline.media.picture import encode

log = logging.getLogger(__name__)

MOST_BYTES = 128 * 2**20  # of the sheets that are kept

Key = TypeVar("Key", bound=Hashable)
Tiles = Iterator[tuple[int, np.ndarray]]  # frame, picture (edge, edge, 3) uint8 RGB


@dataclass(frozen=True)
class Order:
    """A sheet that is to be made: frames, left to right, then top to bottom.

    ground: where there is no picture. name: what the log calls it.
    """

    frames: Sequence[int]
    tiles: Tiles
    ground: tuple[int, int, int]
    name: str


class Sheets(Generic[Key]):
    """The sheets of anything that has a key.

    order: key → what is to be made. edge: of a picture, in pixels; columns: of a sheet.
    """

    def __init__(
        self,
        order: Callable[[Key], Order],
        edge: int,
        columns: int,
        most_bytes: int = MOST_BYTES,
    ):
        self.edge, self.columns, self.most_bytes = edge, columns, most_bytes
        self._order = order
        self._sheets: OrderedDict[Key, bytes] = OrderedDict()  # the one asked for last is last
        self._bytes = 0
        self._wanted: list[Key] = []
        self._making: dict[Key, threading.Lock] = defaultdict(threading.Lock)
        self._lock = threading.Condition()
        self._cores = _Turns(os.cpu_count() or 1)
        self._ahead: threading.Thread | None = None
        self._ended = False

    def get(self, key: Key, at_once: bool = True) -> bytes | None:
        """A JPEG, None where not one of its frames could be shown.

        at_once: before all that was asked for earlier; else when nobody waits.
        """
        with self._lock:
            making = self._making[key]
        with making:  # one thread makes it, others wait for it
            if (kept := self._kept(key)) is None:
                with self._cores.turn(at_once):
                    kept = b"" if self._ended else self._made(self._order(key))
                if self._ended:
                    return None
                self._keep(key, kept)
        return kept or None

    def expect(self, keys: Iterable[Key]) -> None:
        """Make them in the background, in that order, instead of what was expected."""
        with self._lock:
            self._wanted = [key for key in keys if key not in self._sheets][::-1]
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
                self.get(key, at_once=False)
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

    def _made(self, order: Order) -> bytes:
        """The sheet; empty where there is no picture to put on it."""
        places = {frame: place for place, frame in enumerate(order.frames)}
        rows, edge = -(-len(places) // self.columns), self.edge
        sheet = np.empty((rows, self.columns, edge, edge, 3), np.uint8)
        sheet[:] = order.ground
        found = False
        try:
            for frame, picture in order.tiles:
                if self._ended:
                    break
                sheet[divmod(places[frame], self.columns)] = picture
                found = True
        except MimelineError as error:  # what came before it is shown
            log.warning("%s: %s", order.name, error)
        whole = sheet.swapaxes(1, 2).reshape(rows * edge, self.columns * edge, 3)
        return encode(whole, "jpeg") if found else b""


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

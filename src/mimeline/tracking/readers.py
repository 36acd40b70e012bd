"""Which reader reads which format, and where its takes lie."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mimeline.tracking.convention import Convention
from mimeline.tracking.formats import (
    bfm,
    emoca,
    flame,
    livelink,
    mediapipe,
    metrical_tracker,
    openface,
    pyfeat,
    table,
)
from mimeline.tracking.origins import truthful
from mimeline.tracking.take import Take


@dataclass(frozen=True)
class Reader:
    """A format: what reads it, and what a take of it looks like from outside.

    read: path, bad_values and the format's own options → Take. endings: of the files that may be
    takes, the first wins; none where a take is a folder. holds: whether a path is a take of the
    format, by what is in it; it reads little and never raises.
    """

    read: Callable[..., Take]
    convention: Convention
    holds: Callable[[Path], bool]
    endings: tuple[str, ...] = ()


READERS: dict[str, Reader] = {
    module.__name__.rpartition(".")[2]: Reader(
        module.read, module.CONVENTION, module.holds, module.ENDINGS
    )
    # a generic table comes last: what it holds may also be another format's
    for module in (
        livelink,
        pyfeat,
        mediapipe,
        openface,
        metrical_tracker,
        emoca,
        flame,
        bfm,
        table,
    )
}


@dataclass(frozen=True)
class Tracker:
    """The tracking results of a data folder: their format, where they lie, how they are read."""

    reader: Reader
    folder: Path
    reading: Mapping[str, Any]

    @classmethod
    def of(cls, data: Path, format: str, options: Mapping[str, Any], bad_values: str) -> "Tracker":
        """data: the user's folder. format, options: of section `ingest`, paths under data."""
        reading = {key: value for key, value in options.items() if key != "folder"}
        if reading.get("face") is not None:
            reading["face"] = Path(data) / reading["face"]
        return cls(
            READERS[format], Path(data) / options["folder"], reading | {"bad_values": bad_values}
        )

    def takes(self) -> list[Path]:
        """Every take of the folder, by name."""
        if not self.folder.is_dir():
            return []
        return sorted(path for path in self.folder.iterdir() if self._fits(path))

    def result(self, name: str) -> Path | None:
        """The take that bears a name, or None."""
        if not self.reader.endings:
            path = self.folder / name
            return path if path.is_dir() else None
        paths = (
            self.folder / f"{name}{e}" for end in self.reader.endings for e in (end, end.upper())
        )
        return next((path for path in paths if path.is_file()), None)

    def read(self, path: Path) -> Take:
        """The take at path. Raises MimelineError where it cannot be read."""
        return truthful(self.reader.read(path, **self.reading))

    def _fits(self, path: Path) -> bool:
        if path.name.startswith(".") or path.stem.lower().endswith(".loss"):  # a sidecar
            return False
        if path == self.reading.get("face"):
            return False
        if self.reader.endings:
            return path.suffix.lower() in self.reader.endings and path.is_file()
        return path.is_dir() and self.reader.holds(path)

"""What a reader must be told that its files do not say: defaults, a run's configuration, --set."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import yaml

from mimeline.config import checked, validate, value_of
from mimeline.errors import BadConfig, unreadable
from mimeline.tracking.readers import READERS, Tracker

REMEDY = "config/README.md explains every key."


@dataclass(frozen=True)
class Options:
    """How takes are read. data: the folder that paths lie under. ingest: that section, complete.

    format: the one to think of first, or None; named: think of no other. told: keys that somebody
    gave, "openface.fps". exclude: names of files that a run leaves out. videos: where a run's lie;
    film_fps: what it cuts them to; None where no configuration tells. sets: keys of formats that
    were set by hand, as they were written: "fps" or "livelink.fps".
    """

    data: Path
    ingest: Mapping[str, Any]
    format: str | None
    named: bool
    told: frozenset[str]
    exclude: frozenset[str]
    videos: Path | None
    film_fps: Fraction | None
    sets: frozenset[str]

    def tracker(self, format: str) -> Tracker:
        """The reader of a format with its keys."""
        return Tracker.of(self.data, format, self.ingest[format], self.ingest["bad_values"])

    def is_of_the_run(self, path: Path) -> bool:
        """Whether a path lies in the folder of the configuration's takes and is no face model."""
        tracker = self.tracker(self.format)
        here, face = path.absolute(), tracker.reading.get("face")
        return (
            here.parent.resolve() == tracker.folder.resolve()
            and path.name not in self.exclude
            and (face is None or here != face.absolute())
        )

    def refuse_idle(self, formats: Iterable[str]) -> None:
        """Raise BadConfig for a key of --set that none of these formats has."""
        has = {key for format in formats for key in self.ingest[format]} - {"folder"}
        own = {f"{format}.{key}" for format in formats for key in self.ingest[format]}
        meant = self.sets if self.format else {key for key in self.sets if "." not in key}
        if has and (idle := sorted(meant - has - own)):
            raise BadConfig(
                "--set",
                place=", ".join(idle),
                found=f"no such key of {', '.join(sorted(formats))}",
                expected=f"one of {', '.join(sorted(has))}",
                remedy=REMEDY,
            )

    def knows_fps(self, format: str) -> bool:
        """Whether somebody said how many frames a second has."""
        return f"{format}.fps" in self.told


def options(
    config: Path | None = None, sets: Iterable[str] = (), format: str | None = None
) -> Options:
    """The options of `ingest`: the defaults, over them a configuration's, over them KEY=VALUE.

    config: a YAML file as for a run; its ingest.format is then the first to be tried. sets:
    "fps=25", "livelink.angle_unit=degrees" or "ingest.livelink.angle_unit=degrees"; a key that
    names no format holds for all that have it. format: the only one to be tried.
    Raises BadConfig or BadFile for what cannot be used, the first mistake of several.
    """
    if format is not None and format not in READERS:
        raise BadConfig(
            "--format", found=repr(format), expected=f"one of {', '.join(READERS)}", remedy=REMEDY
        )
    values = from_yaml(config) if config else {}
    given = values.get("ingest") or {}
    if not isinstance(given, dict):
        raise BadConfig(
            config, place="key ingest", found=repr(given), expected="keys and values", remedy=REMEDY
        )
    named = format is not None
    if not named and config:
        format = given.get("format", "livelink")
    ingest = {key: dict(v) if isinstance(v, dict) else v for key, v in given.items()}
    by_hand = {key for text in sets if (key := _put(ingest, text))}
    ingest |= {"format": format} if format else {}
    others = {section: values.get(section) or {} for section in ("catalogue", "fetch")}
    settled = checked({"ingest": ingest} | others, str(config or "--set"))
    exclude = frozenset(settled["catalogue"]["files"]["exclude"])
    told = {f"{key}.{k}" for key, v in ingest.items() if isinstance(v, dict) for k in v}
    data = Path(values.get("data_dir") or ".")
    fetch = settled["fetch"]
    return Options(
        data,
        settled["ingest"],
        format,
        named,
        frozenset(told),
        exclude,
        videos=data / fetch["folder"] if config and fetch["folder"] else None,
        film_fps=Fraction(fetch["fps"]) if fetch["fps"] else None,
        sets=frozenset(by_hand),
    )


def _put(ingest: dict[str, Any], text: str) -> str | None:
    """Write KEY=VALUE into the section, wherever the key belongs.

    Returns the key as it was written, "fps" or "livelink.fps", where formats have it.
    """
    key, equals, value = text.partition("=")
    *block, name = key.strip().removeprefix("ingest.").split(".")
    defaults = validate({})["ingest"]
    blocks = {f: v for f, v in defaults.items() if isinstance(v, dict)}
    if name in defaults and not block and name not in blocks:
        homes = [ingest]
    elif len(block) < 2:
        homes = [
            ingest.setdefault(f, {})
            for f, v in blocks.items()
            if name in v and block in ([], [f]) and name != "folder"
        ]
    else:
        homes = []
    if not homes or not equals:
        known = {k for v in blocks.values() for k in v} | defaults.keys() - blocks.keys()
        raise BadConfig(
            "--set",
            place=text if equals else "",
            found="an unknown key" if equals else repr(text),
            expected=f"KEY=VALUE with one of {', '.join(sorted(known - {'folder', 'format'}))}",
            remedy=REMEDY,
        )
    for home in homes:
        home[name] = value_of(value)
    return None if homes == [ingest] else ".".join((*block, name))


def from_yaml(path: Path) -> dict[str, Any]:
    expected = "a configuration in YAML"
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise unreadable(path, error, expected=expected, remedy=REMEDY) from error
    if not isinstance(values, dict):
        raise BadConfig(path, found=type(values).__name__, expected=expected, remedy=REMEDY)
    return values

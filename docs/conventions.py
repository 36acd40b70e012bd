"""Writes the tables of docs/conventions.md from the readers' declarations and golden takes.

`python docs/conventions.py` puts them between the page's `<!-- name -->` and `<!-- /name -->`.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import scipy.io

from mimeline.archives.torch_saved import read_saved
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats import sixdrepnet
from mimeline.tracking.readers import READERS
from mimeline.vocabulary import CHANNELS

PAGE = Path(__file__).with_name("conventions.md")
GOLDEN = Path(__file__).parents[1] / "tests" / "tracking" / "golden"
HEAD = {  # golden take → what the subject does, and the channel that tells it
    "turns_left": ("turns to their left", "head_yaw_left"),
    "lifts_head": ("lifts the head", "head_pitch_up"),
    "tilts_left": ("tilts to their left", "head_tilt_left"),
}
EYES = {
    "looks_left": ("looks to their left", "gaze_left"),
    "looks_up": ("looks up", "gaze_up"),
    "closes_left_eye": ("closes the left eye", "eyeBlinkLeft"),
}
MOVEMENTS = HEAD | EYES
TOLD = 2  # numbers of a file that are shown for a movement: those that change most
OTHERS = re.compile(r"^(frame|FaceScore|confidence|timestamp|[xy]_\d+)$")  # that tell no angle
LABELS = {
    "files": "a take",
    "coefficients": "holds",
    "axes": "axes",
    "rotation": "rotation",
    "angle_unit": "angles in",
    "sides": "left and right",
    "first_frame": "first frame",
    "gap": "no face",
    "never": "never measured",
    "evidence": "how the signs were found",
}


def main() -> None:
    """Write the page anew."""
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


def written(page: str) -> str:
    """The page with every table up to date. Raises ValueError where a table has no place."""
    blocks = {"channels": channel_table()}
    blocks |= {"head": movement_table(HEAD), "eyes": movement_table(EYES)}
    blocks |= {format: format_table(reader.convention) for format, reader in READERS.items()}
    blocks["sixdrepnet"] = format_table(sixdrepnet.CONVENTION)
    for name, block in blocks.items():
        place = re.compile(f"(?<=<!-- {name} -->\n).*?(?=<!-- /{name} -->)", re.DOTALL)
        page, found = place.subn(lambda _, block=block: f"\n{block}\n", page)
        if found != 1:
            raise ValueError(f"{PAGE.name} has {found} places for the table {name}")
    return page


def channel_table() -> str:
    """Our own angles."""
    rows = [
        (f"`{channel}`", f"{does.replace('their left', '*their* left')}", _mirrored(channel))
        for does, channel in MOVEMENTS.values()
    ]
    return _table(("channel", "grows when the subject", "in a mirrored picture"), rows)


def _mirrored(name: str) -> str:
    channel = CHANNELS[name]
    sign = "−" if channel.mirror_sign < 0 else ""
    return f"{sign}`{channel.mirror}`" if channel.mirror != name or sign else "the same"


def movement_table(movements: dict[str, tuple[str, str]]) -> str:
    """By how much a file's numbers change when the subject does something."""
    rows = []
    for format, reader in READERS.items():
        if format == "table":  # its names and signs are the user's
            continue
        cells = []
        for name, (_, channel) in movements.items():
            take = next(iter(sorted((GOLDEN / format).glob(f"{name}*"))), None)
            cells.append(_said(take, reader.convention, channel) if take else "–")
        rows.append((f"[{reader.convention.title}](#{format})", *cells))
    return _table(("format", *(does for does, _ in movements.values())), rows)


def format_table(convention: Convention) -> str:
    """What a format declares."""
    rows = []
    for key, label in LABELS.items():
        value = getattr(convention, key)
        if key == "first_frame":
            value = "counted row by row" if value is None else f"number {value}"
        if value:
            rows.append((label, _escaped(value)))
    for channel in [c for _, c in MOVEMENTS.values()]:
        if text := _sign(convention, channel):
            rows.append((f"`{channel}`", text))
    return _table(rows[0], rows[1:])


def _sign(convention: Convention, channel: str) -> str:
    """How a channel is had from the file's numbers."""
    if channel in convention.meanings:
        return _escaped(convention.meanings[channel]).replace("-", "−", 1)
    signed = [(c, sign) for c, (name, sign) in convention.signs.items() if name == channel]
    texts = [
        f"{'−' if sign < 0 else '+'}{f'{abs(sign):g} ' if abs(sign) != 1 else ''}`{c}`"
        for c, sign in signed
    ]
    return ("mean of " if len(texts) > 1 else "") + ", ".join(texts)


def _said(take: Path, convention: Convention, channel: str) -> str:
    """The numbers that change most from the first frame to the last, in the file's own words.

    Of those that change alike, the ones go first that the channel is read from.
    """
    numbers = _numbers(take)
    numbers = numbers[[name for name in numbers if not OTHERS.search(name)]]
    change = (numbers.iloc[-1] - numbers.iloc[0]).round(3)
    change = change[change.abs() > 0.2 * change.abs().max()]
    source = f"{_sign(convention, channel)} {channel}"
    most = sorted(change.index, key=lambda name: (name not in source, -abs(change[name])))
    more = " …" if len(change) > TOLD else ""
    return "<br>".join(f"`{name}` {_number(change[name])}" for name in most[:TOLD]) + more


def _number(value: float) -> str:
    return f"{value:+.2g}".replace("-", "−")


def _numbers(take: Path) -> pd.DataFrame:
    """A golden take's numbers as its file has them, a row per frame, a column per name."""
    if take.suffix == ".csv":
        table = pd.read_csv(take, skipinitialspace=True)
        return table.select_dtypes("number")
    if take.suffix == ".json":
        return pd.DataFrame(map(_scores, json.loads(take.read_text(encoding="utf-8"))))
    if take.suffix == ".npz":
        with np.load(take) as arrays:
            return _columns({name: arrays[name] for name in arrays.files})
    if take.suffix == ".mat":
        content = scipy.io.loadmat(take)
        return _columns({n: a for n, a in content.items() if not n.startswith("__")})
    return pd.DataFrame(_frames_of(take))


def _scores(frame: dict) -> dict[str, float]:
    """MediaPipe's categories of a frame."""
    faces = frame.get("faceBlendshapes") or frame.get("face_blendshapes") or [frame]
    listed = faces[0]["categories"] if isinstance(faces[0], dict) else faces[0]
    return {c.get("categoryName") or c["category_name"]: c["score"] for c in listed}


def _frames_of(folder: Path) -> Iterator[dict[str, float]]:
    """A row for each `.frame` file, or for each folder of arrays."""
    for path in sorted(folder.rglob("*.frame")):
        saved = read_saved(path, remedy="")
        yield _flat(
            {f"{part}.{k}": v for part in ("flame", "camera") for k, v in saved[part].items()}
        )
    for inner in sorted(path for path in folder.rglob("*") if any(path.glob("*.npy"))):
        yield _flat({path.stem: np.load(path) for path in sorted(inner.glob("*.npy"))})


def _flat(arrays: dict[str, np.ndarray]) -> dict[str, float]:
    """{"pose": (1, 6)} → {"pose[0]": ..., "pose[5]": ...}."""
    return {
        f"{name}[{n}]": float(value)
        for name, array in arrays.items()
        for n, value in enumerate(np.ravel(array))
    }


def _columns(arrays: dict[str, np.ndarray]) -> pd.DataFrame:
    """Arrays with a row per frame, side by side."""
    n_frames = max(len(a) for a in arrays.values() if a.ndim)
    kept = {
        n: a for n, a in arrays.items() if a.ndim and len(a) == n_frames and a.dtype.kind in "fiu"
    }
    return pd.DataFrame(_flat({n: a[row] for n, a in kept.items()}) for row in range(n_frames))


def _escaped(value) -> str:
    """Text as it stands, whatever of it Markdown would take for its own."""
    return re.sub(r"([|_*<])", r"\\\1", " ".join(str(value).split()))


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


if __name__ == "__main__":
    main()

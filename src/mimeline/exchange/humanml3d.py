"""A run's clips in the layout of HumanML3D (Guo et al. 2022), as text-to-motion trainers read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from mimeline.dataset.split import PARTS
from mimeline.dataset.windows import MOSTLY, STD_FLOOR
from mimeline.errors import BadFile
from mimeline.exchange import card
from mimeline.exchange.contents import Contents
from mimeline.exchange.finished import Finished, Shard
from mimeline.exchange.licences import DataSet
from mimeline.exchange.release import Release
from mimeline.exchange.tagged import line
from mimeline.reporting import words
from mimeline.timeline.clock import nearest_frame

FPS = Fraction(20)  # that its loaders take for granted
SHORTEST, TOO_LONG = 40, 200  # frames: what is shorter, or as long, its loaders pass over
MOTIONS, TEXTS = "new_joint_vecs", "texts"
LISTS = {"train": ("train",), "val": ("val",), "test": ("test",), "train_val": ("train", "val")}
LISTS |= {"all": PARTS}


@dataclass
class _Spread:
    """Mean and standard deviation of what was added, per channel."""

    n: int = 0
    sum: np.ndarray | float = 0.0
    squares: np.ndarray | float = 0.0

    def add(self, motion: np.ndarray) -> None:
        values = motion.astype(np.float64)
        self.n += len(values)
        self.sum = self.sum + values.sum(axis=0)
        self.squares = self.squares + (values**2).sum(axis=0)

    @property
    def mean(self) -> np.ndarray:
        return (self.sum / self.n).astype(np.float32)

    @property
    def std(self) -> np.ndarray:
        variance = np.maximum(self.squares / self.n - (self.sum / self.n) ** 2, 0.0)
        return np.maximum(np.sqrt(variance), STD_FLOOR).astype(np.float32)


@dataclass
class _Written:
    """Part → its clips; those that are left out; those that loaders pass over."""

    parts: dict[str, list[str]] = field(default_factory=lambda: {part: [] for part in PARTS})
    left_out: list[dict[str, str]] = field(default_factory=list)
    short: list[str] = field(default_factory=list)
    long: list[str] = field(default_factory=list)


def write(
    folder: Path, run: Finished, sets: Sequence[DataSet], contact: str, fps: Fraction = FPS
) -> Release:
    """Write the data set into an empty folder.

    The channels are those that most frames of the training part have, by name in channels.txt. A
    clip is left out, and left_out.csv says why, where a frame is without a face or lacks one of
    them, or where there is no text: a loader has no place for either. fps: what all motion is
    brought to. Raises BadFile where no training clip is left.
    """
    channels = [n for n in run.measured if run.channels["share"][n] >= MOSTLY]
    (folder / MOTIONS).mkdir()
    (folder / TEXTS).mkdir()
    contents, spread, written = Contents(), _Spread(), _Written()
    for shard in run.shards():
        kept = []
        for clip, valid, motion in _clips(shard, channels):
            told = [*clip.texts, *run.descriptions.get(clip.clip_id, [])]
            lines = list(dict.fromkeys(filter(None, map(line, told))))
            if why := _unfit(valid, motion, channels, lines):
                written.left_out.append({"clip_id": clip.clip_id, "part": clip.part} | why)
                continue
            motion = resampled(motion, Fraction(int(clip.fps_num), int(clip.fps_den)), fps)
            np.save(folder / MOTIONS / f"{clip.clip_id}.npy", motion, allow_pickle=False)
            text = "".join(f"{told}\n" for told in lines)
            (folder / TEXTS / f"{clip.clip_id}.txt").write_text(text, encoding="utf-8")
            if clip.part == "train":
                spread.add(motion)
            _note(written, clip, len(motion))
            kept.append(clip.clip_id)
        contents.add(shard.of(kept))
    if not written.parts["train"]:
        raise _nothing_to_train(run, written.left_out)
    _write_lists(folder, written.parts)
    np.save(folder / "Mean.npy", spread.mean, allow_pickle=False)
    np.save(folder / "Std.npy", spread.std, allow_pickle=False)
    (folder / "channels.txt").write_text("".join(f"{n}\n" for n in channels), encoding="utf-8")
    written.left_out.sort(key=lambda row: row["clip_id"])
    notes = _passed_over(written)
    release = Release(run, tuple(sets), contact, contents, channels, written.left_out, notes)
    release.write_tables(folder)
    card.write(
        folder / "README.md",
        "humanml3d.md.j2",
        release,
        splits={},
        fps=fps,
        short=len(written.short),
        long=len(written.long),
        shortest=SHORTEST,
        too_long=TOO_LONG,
        floor=STD_FLOOR,
    )
    return release


def resampled(motion: np.ndarray, rate: Fraction, fps: Fraction) -> np.ndarray:
    """Motion (L, D) at rate frames per second as motion at fps, as long as it was.

    As `mimeline.motion.resampling` does (Fritsch & Carlson 1980, PCHIP), all channels at once:
    here each is known in every frame.
    """
    n = max(1, nearest_frame(Fraction(len(motion)) / rate, fps))
    if fps == rate or len(motion) == 1:
        return np.repeat(motion, n, axis=0) if len(motion) == 1 else motion
    at = np.minimum(np.arange(n) * float(rate / fps), len(motion) - 1)  # (n,) frames of motion
    curve = PchipInterpolator(np.arange(len(motion)), motion.astype(np.float64), axis=0)
    return curve(at).astype(np.float32)


def _clips(shard: Shard, channels: list[str]) -> Iterator[tuple]:
    """Each clip's row, its frames that are valid (L,) and its motion (L, D) float32."""
    valid = shard.motion["valid"].to_numpy(bool)
    motion = shard.motion[channels].to_numpy(np.float32)
    start = 0
    for clip in shard.clips.itertuples():
        own = slice(start, start + int(clip.n_frames))
        start = own.stop
        yield clip, valid[own], motion[own]


def _unfit(
    valid: np.ndarray, motion: np.ndarray, channels: list[str], lines: list[str]
) -> dict[str, str] | None:
    """Why a clip has no place in the layout: reason and detail; None where it has."""
    if lost := int((~valid).sum()):
        detail = f"{lost} of {words.plural(len(valid), 'frame')}"
        return {"reason": "frames without a face", "detail": detail}
    lacking = [channels[i] for i in np.flatnonzero(~np.isfinite(motion).all(axis=0))]
    if lacking:
        more = f" and {len(lacking) - 1} more" if lacking[1:] else ""
        return {"reason": "a channel is not measured", "detail": lacking[0] + more}
    return None if lines else {"reason": "no text", "detail": ""}


def _note(written: _Written, clip, frames: int) -> None:
    written.parts[clip.part].append(clip.clip_id)
    if frames < SHORTEST:
        written.short.append(clip.clip_id)
    if frames >= TOO_LONG:
        written.long.append(clip.clip_id)


def _passed_over(written: _Written) -> tuple[str, ...]:
    """What the usual loaders do with clips that they find too short or too long."""
    told = {f"shorter than {SHORTEST}": written.short, f"of {TOO_LONG} or more": written.long}
    return tuple(
        f"the usual loaders pass over {words.clips(len(ids))} {which} frames (such as {min(ids)}); "
        "--fps sets another rate"
        for which, ids in told.items()
        if ids
    )


def _write_lists(folder: Path, parts: dict[str, list[str]]) -> None:
    for name, of in LISTS.items():
        ids = sorted(clip_id for part in of for clip_id in parts[part])
        (folder / f"{name}.txt").write_text("".join(f"{i}\n" for i in ids), encoding="utf-8")


def _nothing_to_train(run: Finished, left_out: list[dict[str, str]]) -> BadFile:
    reasons = sorted({row["reason"] for row in left_out if row["part"] == "train"})
    return BadFile(
        run.results,
        found=f"no training clip that is whole ({words.listing(reasons) or 'there is none'})",
        expected="clips with a face and all channels in each frame, and a text",
        remedy="The other layout keeps such clips: --to huggingface. Texts are made by "
        f"{run.run.command('--until', 'describe')}.",
    )

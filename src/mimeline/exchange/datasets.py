"""A run's clips as a data set for other trainers, in a folder that is whole or not there."""

import shlex
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Literal

from mimeline.atomic import whole_folder
from mimeline.clips.admission import SAFE_ID
from mimeline.errors import BadFile, printable
from mimeline.exchange.finished import Finished, finished
from mimeline.exchange.licences import DataSet, Told, data_sets, require_permission
from mimeline.exchange.release import ABOUT, LEFT_OUT, Release
from mimeline.reporting import words

Layout = Literal["huggingface", "humanml3d"]
LAYOUTS: tuple[Layout, ...] = ("huggingface", "humanml3d")
MB = 10**6
LOADING: dict[Layout, str] = {
    "huggingface": """from datasets import load_dataset
clips = load_dataset({folder!r})
pandas.DataFrame(clips["train"][0]["motion"])  # (frames, channels)""",
    "humanml3d": """name = open({folder!r} + "/train.txt").readline().strip()
motion = numpy.load({folder!r} + f"/new_joint_vecs/{{name}}.npy")  # (frames, channels)
channels = open({folder!r} + "/channels.txt").read().split()""",
}


@dataclass(frozen=True)
class Exported:
    """What was written, and where; bytes: all files together."""

    folder: Path
    layout: Layout
    release: Release
    bytes: int

    def __str__(self) -> str:
        """What to know of it, and how to load it."""
        *parts, every = self.release.contents.parts
        told = ", ".join(f"{part.name} {words.count(part.clips)}" for part in parts)
        lines = [
            f"wrote {self.folder} ({self.layout}): {words.clips(every.clips)}, "
            f"{words.minutes(every.seconds)} minutes, {_size(self.bytes)}: {told}"
        ]
        left_out = self.release.left_out
        if left_out:
            reasons = Counter(row["reason"] for row in left_out).most_common()
            why = ", ".join(f"{reason} {words.count(n)}" for reason, n in reasons)
            lines.append(f"left out {words.clips(len(left_out))}: {why}; {LEFT_OUT} has each")
        lines += [f"note: {note}" for note in self.release.notes]
        for own in self.release.sets:
            said = own.licence or "not told"
            lines.append(f"licence of {own.name}: {said}{_all_the_same(own)}")
        if self.release.missing:
            lines.append(f"not told, to be filled in: {words.listing(self.release.missing)}")
        loading = LOADING[self.layout].format(folder=str(self.folder.resolve()))
        return "\n".join([*map(printable, lines), "to load it:", *_indented(loading)])


def export(
    results: Path,
    layout: Layout,
    folder: Path,
    told: Told,
    overwrite: bool = False,
    max_mb: int = 256,
    fps: Fraction | None = None,
) -> Exported:
    """Write the clips of a run's parts into a folder.

    told: what is said of the data sets that they are of. overwrite: replace an earlier export.
    max_mb: of a Parquet file (huggingface), in memory. fps: of the motion (humanml3d); None: its
    loaders' own. Raises NotPermitted where a licence forbids passing on what is made, or nobody
    has told one; NoSuchFile where the run has not come so far; BadFile where the folder is taken.
    """
    if fps is not None and layout != "humanml3d":
        raise BadFile(
            "--fps",
            found=f"a frame rate with --to {layout}",
            expected="it with --to humanml3d",
            remedy="Leave it out: here each clip keeps its own.",
        )
    run = finished(results)
    sets = data_sets(run.run, run.clips, told)
    require_permission(sets, results)
    _require_plain_names(run)
    _require_free(folder, overwrite)
    with whole_folder(folder) as new:
        release = _writer(layout, max_mb, fps)(new, run, sets, told.contact)
        size = sum(path.stat().st_size for path in new.rglob("*") if path.is_file())
    return Exported(folder, layout, release, size)


def _writer(layout: Layout, max_mb: int, fps: Fraction | None) -> Callable[..., Release]:
    if layout == "huggingface":
        from mimeline.exchange import hugging_face

        return lambda *args: hugging_face.write(*args, max_bytes=max_mb * MB)
    from mimeline.exchange import humanml3d  # torch loads slowly

    return lambda *args: humanml3d.write(*args, fps=fps or humanml3d.FPS)


def _require_plain_names(run: Finished) -> None:
    """Raises BadFile for an id that is no plain file name: what the run makes of it is harmless."""
    for clip_id in run.clips["clip_id"]:
        if not SAFE_ID.fullmatch(clip_id):
            raise BadFile(
                run.results,
                place=f"clip {clip_id!r}",
                found="an id that is no plain file name",
                expected="ids of a-z 0-9 . _ -",
                remedy="Run the catalogue again: it leaves out such ids and says so.",
            )


def _require_free(folder: Path, overwrite: bool) -> None:
    """Raises BadFile unless the folder is new or empty or, to be replaced, an earlier export."""
    if not folder.exists() and not folder.is_symlink():
        return
    if folder.is_symlink() or not folder.is_dir():
        found, remedy = "a file, or a link", "Name a folder."
    elif not (there := {path.name for path in folder.iterdir()}):
        return
    elif ABOUT not in there:
        found, remedy = "a folder with something else in it", "Name another one; it stays."
    elif odd := sorted(name for name in there if name.startswith(".")):
        found = f"an export with {odd[0]} in it"
        remedy = "Name another one, and copy it over: what you keep there would be lost."
    elif not overwrite:
        found = "an export already"
        remedy = "Somebody may have filled in its card: name another one, or say --overwrite."
    else:
        return
    raise BadFile(folder, found=found, expected="a new folder", remedy=remedy)


def _all_the_same(own: DataSet) -> str:
    """What is added of a data set that is passed on although it is not known to be permitted."""
    if own.redistribution == "permitted":
        return ""
    forbids = "it forbids passing this on", "nobody here knows whether it may be passed on"
    why = forbids[own.redistribution == "unknown"]
    return f" — {why}; written because of {shlex.join(['--redistribute', own.name])}"


def _size(size: int) -> str:
    if size < MB:
        return f"{words.count(round(size / 1000))} kB"
    return f"{size / MB:.1f} MB" if size < 100 * MB else f"{words.count(round(size / MB))} MB"


def _indented(text: str) -> list[str]:
    return [f"  {line}" for line in text.splitlines()]

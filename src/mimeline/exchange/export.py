"""A run's timelines as files that people open, one for each clip."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mimeline import tables
from mimeline.annotation.timelines import timelines_of
from mimeline.clips.media_of_run import files_of
from mimeline.errors import NoSuchFile
from mimeline.exchange.conversion import Written, write_each
from mimeline.inspection.asked import meant
from mimeline.inspection.left_behind import decisions, rows_of
from mimeline.inspection.remedies import DEFAULT, named
from mimeline.reporting import words
from mimeline.run import recall
from mimeline.timeline import files


@dataclass(frozen=True)
class Export:
    """What was written.

    missed: a problem for each name that nobody has. without: clips that were asked for and have no
    timeline. command: how the run is scored against the files.
    """

    written: Written
    missed: list[str]
    without: list[str]
    command: str
    results: Path

    def __str__(self) -> str:
        """A few lines."""
        lines = [str(self.written)]
        if self.without:
            why = _why(self.without[0], self.results)
            lines.append(f"{words.clips(len(self.without))} without a timeline: {why}")
        return "\n".join([*lines, f"to score the run by them: {self.command}"])


def export(
    results: Path, asked: Sequence[str], folder: Path, format: str, overwrite: bool = False
) -> Export:
    """Write the timelines of a run's clips into a folder.

    asked: ids, patterns of ids or sources, as for `why`; empty: all clips that have a timeline.
    Raises NoSuchFile where no run has been or has not annotated, or has no timeline of any clip
    that is asked for; BadFile where nobody has any of the ids and for what `write_each` refuses.
    """
    known = decisions(results)["clip_id"].unique()
    clips = rows_of(results, "pose", tables.CLIPS)
    timelines = timelines_of(
        rows_of(results, "annotate", tables.INTERVALS),
        rows_of(results, "annotate", tables.FRAMES),
        clips,
    )
    if not timelines:
        raise NoSuchFile(
            results,
            found="no timelines",
            expected="those of a run that has come to annotate",
            remedy=f"{recall(results).command('--until', 'annotate')} makes them.",
        )
    ids, missed = list(timelines), []
    if asked:
        catalogue = rows_of(results, "catalogue", tables.CLIPS).set_index("clip_id", drop=False)
        ids, _, missed = meant(asked, known, catalogue, results)
    without = [clip_id for clip_id in ids if clip_id not in timelines]
    chosen = [timelines[clip_id] for clip_id in ids if clip_id in timelines]
    if not chosen:
        raise NoSuchFile(
            results,
            found=f"no timeline of {words.clips(len(without))} that you name",
            expected="clips that the run kept",
            remedy=f"{_why(without[0], results)} tells what became of it.",
        )
    films = {} if files.MEDIA in files.FORMATS[format].loses else files_of(Path(results), "film")
    written = write_each(chosen, folder, format, films, overwrite=overwrite)
    command = recall(results).command(evaluate={"truth": _as_the_run_finds(folder, results)})
    return Export(written, missed, without, command, results)


def _as_the_run_finds(folder: Path, results: Path) -> str:
    """The folder's path where the run is started: where its results are in their usual place.

    Of other results nobody knows that place.
    """
    full = folder.resolve()
    is_below = Path(results) == DEFAULT and full.is_relative_to(Path.cwd())
    return str(full.relative_to(Path.cwd()) if is_below else full)


def _why(clip_id: str, results: Path) -> str:
    """The command that tells what became of a clip."""
    return shlex.join(["mimeline", "why", clip_id, *named(results)])

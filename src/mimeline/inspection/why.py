"""What became of a clip, stage by stage."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.clips.intervals import timed
from mimeline.errors import printable
from mimeline.inspection import layout
from mimeline.inspection.asked import meant
from mimeline.inspection.layout import BOLD, FAINT, GREEN, RED, YELLOW, Paint
from mimeline.inspection.left_behind import decisions, files_with, has_run, rows_of
from mimeline.inspection.remedies import Step, remedy
from mimeline.reporting import words
from mimeline.reporting.funnel import STAGES
from mimeline.run import Run, recall

AT_LENGTH = 3  # more clips than that have a line each
CODES = {"kept": GREEN, "dropped": RED, "failed": RED}


@dataclass(frozen=True)
class Decision:
    """A row of the ledger. text: what it says, in words; empty for a clip that is just kept."""

    stage: str
    status: str
    rule: str | None
    value: float | None
    limit: float | None
    unit: str | None
    first_frame: int | None
    last_frame: int | None
    detail: str | None
    text: str


@dataclass(frozen=True)
class Story:
    """A clip's way. outcome: in a few words; stages: that decided, or would; todo: if it is lost.

    facts: what the catalogue tells. files: where its film and the rows of it lie.
    """

    clip_id: str
    status: str
    outcome: str
    facts: dict[str, str]
    decisions: list[Decision]
    todo: list[Step]
    files: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """The stories that were asked for.

    of: the source that they are all clips of, if one was. waiting: stages that have not run.
    missed: a problem for each name that nobody has.
    """

    stories: list[Story]
    of: str
    waiting: list[str]
    missed: list[str] = field(default_factory=list)


def why(results: Path, asked: Sequence[str]) -> Found:
    """What each stage decided on clips.

    results: a run's folder. asked: ids, patterns of ids such as `oC9r*`, or a source's name: all
    its clips. An id may end in .mp4. Raises NoSuchFile where no run has been; BadFile where
    nobody has any of the ids, with those that are near.
    """
    rows = decisions(results)
    clips = rows_of(results, "catalogue", tables.CLIPS).set_index("clip_id", drop=False)
    ids, of, missed = meant(asked, pd.unique(rows["clip_id"]), clips, results)
    rows = rows[rows["clip_id"].isin(ids)].sort_values(["place", "rule"], kind="stable")
    films = rows_of(results, "fetch", tables.CLIPS, ["clip_id", "media"]).set_index("clip_id")
    parts = rows_of(results, "split", tables.SPLIT).set_index("clip_id")
    by_clip = dict(list(rows.groupby("clip_id")))
    stories, run = [], recall(results)
    for clip_id in ids:
        made = [_decision(row) for row in by_clip[clip_id].itertuples()]
        last = made[-1]
        files = {}
        if len(ids) <= AT_LENGTH:
            files = _files(results, clip_id, films["media"].get(clip_id))
        stories.append(
            Story(
                clip_id,
                last.status,
                _outcome(last, parts["part"].get(clip_id)),
                _facts(clips.loc[clip_id]) if clip_id in clips.index else {},
                made,
                [] if last.status == "kept" else _todo(last, results, run),
                files,
            )
        )
    waiting = [stage for stage in STAGES if not has_run(results, stage)]
    return Found(stories, of, waiting, missed)


def as_text(found: Found, colour: bool = False) -> str:
    """What a person reads: a clip at length, several with a line each. colour: ANSI is welcome."""
    paint = layout.painter(colour)
    if len(found.stories) > AT_LENGTH:
        return _list(found, paint)
    parts = ["\n".join(_told(story, found.waiting, paint)) + "\n" for story in found.stories]
    return "\n".join(parts)


def as_json(found: Found) -> str:
    """What a program reads."""
    return json.dumps([asdict(s) for s in found.stories], indent=1, ensure_ascii=False) + "\n"


def _todo(last: Decision, results: Path, run: Run) -> list[Step]:
    """What to do about a clip that is lost."""
    return remedy(last.stage, last.rule, last.value, last.detail, results, run)


def _decision(row) -> Decision:
    facts = {
        name: None if pd.isna(value := getattr(row, name)) else value
        for name in Decision.__dataclass_fields__
        if name != "text"
    }
    for name in ("first_frame", "last_frame"):
        facts[name] = None if facts[name] is None else int(facts[name])
    return Decision(**facts, text=_said(facts))


def _said(facts: dict) -> str:
    """The rule in words, the value against the limit, the frames, the detail."""
    if facts["rule"] is None:
        return facts["detail"] or ""
    rule, detail = words.rule(facts["rule"]), facts["detail"] or ""
    if facts["status"] == "kept" and detail.startswith(words.NOT_APPLIED):
        return f"“{rule}” was not applied: {detail.removeprefix(words.NOT_APPLIED)}"
    value, limit = (words.measure(facts[name], facts["unit"]) for name in ("value", "limit"))
    numbers = [value, f"limit {limit}" if limit else "", _frames(facts)]
    if told := ", ".join(filter(None, numbers)):
        rule = f"{rule}: {told}"
    return f"{rule}{'; ' if told else ': '}{detail}" if detail else rule


def _frames(facts: dict) -> str:
    first, last = facts["first_frame"], facts["last_frame"]
    if first is None:
        return ""
    return f"frame {first}" if last in (None, first) else f"frames {first}–{last}"


def _outcome(last: Decision, part: str | None) -> str:
    if last.status != "kept":
        return f"{last.status} by {last.stage}: {words.rule(last.rule)}"
    return f"kept, in {part}" if part else f"kept so far, by {last.stage}"


def _facts(clip: pd.Series) -> dict[str, str]:
    """What the catalogue tells of the clip; what it does not tell is left out."""
    length = clip["end_s"] - clip["start_s"]
    facts = {"source": f"{clip['source_id']}, {clip['start_s']:g}–{clip['end_s']:g} s"}
    facts["source"] += f" ({length:.4g} s)"
    facts["person"] = clip["subject_id"]
    if pd.notna(clip["width"]) and pd.notna(clip["height"]):
        facts["crop"] = f"{clip['width']} x {clip['height']} pixels"
    facts["actions"] = ", ".join(map(timed, clip["actions"]))
    facts["emotion"] = ", ".join(map(timed, clip["emotions"])) or clip["emotion"]
    facts["attributes"] = ", ".join(clip["attributes"])
    return {name: text for name, text in facts.items() if isinstance(text, str) and text}


def _files(results: Path, clip_id: str, film: str | None) -> dict[str, str]:
    """Where the clip's film lies, and the tables that tell of its frames."""
    places = {
        "motion": files_with(results, tables.MOTION, "ingest", clip_id),
        "timeline": files_with(results, tables.INTERVALS, "annotate", clip_id),
        "descriptions": files_with(results, tables.DESCRIPTIONS, "describe", clip_id),
    }
    files = {} if pd.isna(film) else {"film": film}
    return files | {name: str(paths[0]) for name, paths in places.items() if paths}


def _told(story: Story, waiting: list[str], paint: Paint) -> list[str]:
    head = f"{paint(printable(story.clip_id), BOLD)}: {paint(story.outcome, CODES[story.status])}"
    lines = [head, *layout.listed(story.facts, paint), ""]
    width = max(map(len, STAGES))
    for stage in STAGES:
        made = [decision for decision in story.decisions if decision.stage == stage]
        if not made:
            continue
        for n, decision in enumerate(made):
            name = (stage if n == 0 else "").ljust(width)
            status = decision.status.ljust(7) if decision.text else decision.status
            noted = decision.status == "kept" and decision.text
            text = layout.wrapped(decision.text, width + 13)
            first, *more = [paint(line, YELLOW) for line in text] if noted else text
            told = f"  {first}" if decision.text else ""
            lines.append(f"  {name}  {paint(status, CODES[decision.status])}{told}")
            lines += [" " * (width + 13) + line for line in more]
    later = STAGES[STAGES.index(story.decisions[-1].stage) + 1 :]
    told = "none of them saw it" if story.status != "kept" else "not run yet"
    lines += [paint(f"  {', '.join(later)}: {told}", FAINT)] if later else []
    lines += ["", f"  {paint('what to do', FAINT)}"] if story.todo else []
    for step in story.todo:
        lines += ["    " + line for line in layout.wrapped(step.say, 4)]
        lines.append(f"      {step.command}")  # whole, however long, to be copied
    lines += [""] if story.files else []
    label = max(map(len, story.files), default=0)
    for name, path in story.files.items():  # whole, however long, to be copied
        lines.append(f"  {paint(name.ljust(label), FAINT)}  {printable(path)}")
    return lines


def _list(found: Found, paint: Paint) -> str:
    kept = sum(story.status == "kept" for story in found.stories)
    head = words.clips(len(found.stories)) + (f" of {found.of}" if found.of else "")
    lines = [f"{paint(printable(head), BOLD)}, {words.count(kept)} kept"]
    width = max(len(printable(story.clip_id)) for story in found.stories)
    for story in found.stories:
        name, outcome = printable(story.clip_id).ljust(width), story.outcome
        lines.append(f"  {name}  {paint(outcome, CODES[story.status])}")
    return "\n".join(lines) + "\n"

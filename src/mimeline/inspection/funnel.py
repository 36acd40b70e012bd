"""How many clips came through each stage of a run, and how many would with other limits."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mimeline import tables
from mimeline.clips.select import BESIDES
from mimeline.errors import BadFile
from mimeline.inspection import layout
from mimeline.inspection.layout import BOLD, FAINT, RED, YELLOW, Paint
from mimeline.inspection.left_behind import decisions, has_run, ledgers, rows_of
from mimeline.inspection.what_if import Change, WhatIf, what_if
from mimeline.reporting import funnel as way
from mimeline.reporting import words

NAMED = 6  # clips named beside a change
MINUS = "\N{MINUS SIGN}"


@dataclass(frozen=True)
class Found:
    """A run's funnel, of the stages that agree with each other; problem: what does not agree.

    waiting: stages that have not run. besides: clips that another rule dropped and that are
    duplicates, too.
    """

    results: Path
    funnel: way.Funnel
    waiting: list[str]
    besides: list[str]
    problem: str

    @property
    def sound(self) -> bool:
        """Whether every clip that came in is accounted for."""
        return not self.problem


def funnel(results: Path, configs: Sequence[Path], sets: Sequence[str]) -> Found | WhatIf:
    """The clips of a run, stage by stage; or, with sets, what other options would change.

    results: a run's folder. configs, sets: as for `what_if`. Raises NoSuchFile where no run has
    been; BadConfig for what cannot be asked; BadFile where even the first stage loses a clip.
    """
    rows = decisions(results)
    if sets:
        return what_if(results, configs, sets, rows)
    paths = ledgers(results)
    run = [stage for stage in way.STAGES if has_run(results, stage)]
    waiting = [stage for stage in way.STAGES if stage not in run]
    problem = ""
    for count in range(len(run), 0, -1):
        of_stages = [path for path in paths if _stage_of(path, results) in run[:count]]
        try:
            found = way.funnel(of_stages, through=_through(results, run[count - 1]))
        except BadFile as error:
            if count == 1:
                raise
            problem = str(error)
        else:
            break
    told = rows["detail"].str.contains(BESIDES, regex=False, na=False)
    besides = rows.loc[told & (rows["stage"] == "select"), "clip_id"].tolist()
    return Found(Path(results), found, waiting, besides, problem)


def _stage_of(path: Path, results: Path) -> str:
    return path.relative_to(results).parts[0]


def _through(results: Path, stage: str) -> set[str]:
    """The clips in the stage's own table."""
    table = tables.SPLIT if stage == "split" else tables.CLIPS
    return set(rows_of(results, stage, table, ["clip_id"])["clip_id"])


def as_text(found: Found | WhatIf, colour: bool = False) -> str:
    """What a person reads: the funnel, or what would change. colour: ANSI codes are welcome."""
    paint = layout.painter(colour)
    if isinstance(found, WhatIf):
        return "\n".join(_told(found, paint)) + "\n"
    stages = found.funnel.stages
    ran = [stage for stage in stages if stage.name not in found.waiting]
    head = f"{words.clips(found.funnel.entered)} in, {words.count(found.funnel.kept)} left"
    lines = [f"{paint(str(found.results), BOLD)}: {head} after {ran[-1].name}", ""]
    rows = [("stage", "in", "kept", "dropped", "failed")]
    rows += [(s.name, *map(words.count, (s.entered, s.kept, s.dropped, s.failed))) for s in ran]
    table = layout.table(rows)
    indent = max(map(len, table)) + 3
    lines.append(paint(table[0], FAINT))
    for stage, line in zip(ran, table[1:], strict=True):
        reasons = ", ".join(f"{reason} {words.count(n)}" for reason, n in stage.reasons)
        first, *more = layout.wrapped(reasons, indent)
        lines.append(f"{line.ljust(indent)}{first}".rstrip())
        lines += [" " * indent + text for text in more]
    if found.waiting:
        lines.append(paint(f"  not run yet: {', '.join(found.waiting)}", FAINT))
    notes = [f"{n.stage}: {n.text}: {words.clips(n.clips)}" for n in found.funnel.notes]
    if found.besides:
        told = "dropped for another reason, and a duplicate of another clip as well"
        notes.insert(0, f"select: {told}: {_named(found.besides)}")
    lines += ["", paint("notes", YELLOW)] if notes else []
    for text in notes:
        first, *more = layout.wrapped(text, 4)
        lines += [f"  - {first}", *(f"    {line}" for line in more)]
    if found.problem:
        lines += ["", paint("problems", RED), *(f"  {t}" for t in layout.wrapped(found.problem, 2))]
    return "\n".join(lines) + "\n"


def as_json(found: Found | WhatIf) -> str:
    """What a program reads."""
    if isinstance(found, WhatIf):
        return json.dumps(asdict(found), indent=1, ensure_ascii=False) + "\n"
    held = {
        "stages": [asdict(stage) | {"in": stage.entered} for stage in found.funnel.stages],
        "waiting": found.waiting,
        "duplicates_besides": found.besides,
        "notes": [asdict(note) for note in found.funnel.notes],
        "problem": found.problem,
    }
    return json.dumps(held, indent=1, ensure_ascii=False) + "\n"


def _told(asked: WhatIf, paint: Paint) -> list[str]:
    lines: list[str] = []
    for stage, now in asked.now.items():
        changes = [change for change in asked.changes if change.stage == stage]
        lines += [""] if lines else []
        if len(changes) > 1:
            lines += _several(changes, now, paint)
        else:
            lines += _one(changes[0], now, asked, paint)
        if differ := asked.differ[stage]:
            text = (
                f"The ledger of {stage} says otherwise of {words.clips(len(differ))}, such as "
                f"{differ[0]}, than the configuration here would: the results were made with "
                f"other options. {asked.remedy}"
            )
            lines += ["", *(paint(f"  {line}", YELLOW) for line in layout.wrapped(text, 2))]
    return lines


def _one(change: Change, now: Change, asked: WhatIf, paint: Paint) -> list[str]:
    keys = " and ".join(
        f"{key} = {_shown(value)} (now {_shown(now.asked[key])})"
        for key, value in change.asked.items()
    )
    entered = change.kept + sum(change.reasons.values())
    facts = {
        change.stage: f"keeps {words.count(change.kept)} of {words.clips(entered)}, "
        f"{_signed(change.kept - now.kept)}: {words.minutes(change.seconds)} minutes"
    }
    counts = {rule: (now.reasons.get(rule, 0), n) for rule, n in change.reasons.items()}
    counts |= {rule: (n, 0) for rule, n in now.reasons.items() if rule not in change.reasons}
    told = [
        f"{words.rule(rule)} {words.count(before)} → {words.count(after)}"
        for rule, (before, after) in counts.items()
        if before != after
    ]
    facts |= {"dropped": ", ".join(told)} if told else {}
    if change.gained:
        facts["gained"] = _named(change.gained)
        if after := asked.beyond[change.stage]:
            facts["not known"] = (
                f"what becomes of them after: {words.listing(after)} never saw them"
            )
    if change.lost:
        facts["lost"] = _named(change.lost)
        facts["of these"] = f"{words.count(change.through)} are kept by the run as it stands"
    if not (change.gained or change.lost):
        facts["changes"] = "none"
    return [paint(line, BOLD) for line in layout.wrapped(f"with {keys}", 0)] + [
        *layout.listed(facts, paint)
    ]


def _several(changes: list[Change], now: Change, paint: Paint) -> list[str]:
    """A line for each value that was asked for, and one for the run's own."""
    values = {key: {_shown(change.asked[key]) for change in changes} for key in now.asked}
    keys = sorted(values, key=lambda key: -len(values[key]))  # stable
    shown = changes if any(change.is_now for change in changes) else [*changes, now]
    shown = sorted(shown, key=lambda c: (c.asked[keys[0]] is None, c.asked[keys[0]]))
    rows = [
        (change.stage, *(_shown(change.asked[key]) for key in keys), *_counts(change, now))
        for change in shown
    ]
    head, *lines = layout.table([("", *keys, "kept", "", "minutes", ""), *rows])
    return [paint(head, FAINT), *lines]


def _counts(change: Change, now: Change) -> tuple[str, str, str, str]:
    more = "" if change.is_now else _signed(change.kept - now.kept)
    mark = "now" if change.is_now else ""
    return words.count(change.kept), more, words.minutes(change.seconds), mark


def _signed(number: int) -> str:
    if not number:
        return "as many as now"
    return f"{'+' if number > 0 else MINUS}{words.count(abs(number))}"


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_shown, value)) or "none"
    return "null" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _named(ids: list[str]) -> str:
    more = f" and {words.count(len(ids) - NAMED)} more" if len(ids) > NAMED else ""
    return f"{words.clips(len(ids))}: {', '.join(ids[:NAMED])}{more}"

"""Before a long training: is there enough of a run's data, of what, and what is odd."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.config import checked
from mimeline.dataset.check import Check, Finding, check
from mimeline.dataset.split import PARTS
from mimeline.errors import BadFile, NoSuchFile
from mimeline.inspection import layout
from mimeline.inspection.layout import BOLD, FAINT, RED, YELLOW, Paint
from mimeline.inspection.left_behind import rows_of
from mimeline.inspection.what_if import configured
from mimeline.reporting import words
from mimeline.run import recall
from mimeline.training.train import LEAST_FRAMES
from mimeline.vocabulary import ACTIONS, CHANNELS

HABIT = 0.2  # |phi| from which two actions count as tied
SHOWN = 5  # habits, and channels with outliers


def check_data(results: Path, configs: Sequence[Path]) -> tuple[Check, dict[str, int]]:
    """What a training of the timeline model would find, and its window, batch and steps.

    results: a run's folder. configs: files over config/config.yaml; without any, what the run was
    told. Raises NoSuchFile where annotate or split has not run, BadFile where a table is damaged or
    the split is empty, BadConfig for a configuration that cannot be.
    """
    results = Path(results)
    has_run = {
        "annotate": any(results.glob("annotate/[0-9]*/frames.parquet")),
        "split": (results / "split" / "split.parquet").is_file(),
    }
    if missing := [stage for stage, there in has_run.items() if not there]:
        raise NoSuchFile(
            results,
            found=f"no results of {words.listing(missing)}"
            if results.is_dir()
            else "no such folder",
            expected="annotated and divided clips",
            remedy=f"Type {recall(results).command('--until', 'annotate', 'split')} first, or name "
            "the results of another run: --results FOLDER.",
        )
    split = rows_of(results, "split", tables.SPLIT)
    if split.empty:
        path = results / "split" / "split.parquet"
        raise BadFile(
            path,
            found=f"no clip: {tables.reason(path) or 'it does not say why'}",
            expected="clips to train on",
            remedy=f"mimeline funnel --results {results} tells where they are lost.",
        )
    options = checked(configured(results, configs), "the configuration")["train"]["timeline"]
    plan = {key: options[key] for key in ("window", "batch", "steps")}
    found = check(
        rows_of(results, "pose", tables.CLIPS),
        rows_of(results, "ingest", tables.MOTION),
        rows_of(results, "annotate", tables.FRAMES),
        split,
        rows_of(results, "split", tables.STATISTICS),
        **plan,
        least_frames=LEAST_FRAMES,
    )
    return found, plan


def as_json(found: Check, plan: dict[str, int]) -> str:
    """What a program reads: shares of 1, angles in radians, null for what is not known."""
    held = {
        "training": plan | {"times_seen": found.seen},
        "frame_rates": {str(rate): clips for rate, clips in sorted(found.rates.items())},
        "parts": _records(found.parts.rename_axis("part").reset_index()),
        "channels": _records(found.channels.rename_axis("channel").reset_index()),
        "actions": _records(found.actions),
        "habits": _records(found.habits),
        "problems": [_as_record(finding) for finding in found.findings if finding.problem],
        "remarks": [_as_record(finding) for finding in found.findings if not finding.problem],
    }
    return json.dumps(held, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _records(table: pd.DataFrame) -> list[dict]:
    return json.loads(table.to_json(orient="records"))


def _as_record(finding: Finding) -> dict[str, str]:
    return {"what": finding.what, "where": finding.where, "remedy": finding.remedy}


def as_text(found: Check, plan: dict[str, int], results: Path, colour: bool = False) -> str:
    """What a person reads. colour: ANSI codes are welcome."""
    paint = layout.painter(colour)
    problems = [finding for finding in found.findings if finding.problem]
    remarks = [finding for finding in found.findings if not finding.problem]
    told = words.listing(
        [words.plural(len(problems), "problem"), words.plural(len(remarks), "remark")]
    )
    lines = [f"{paint(str(results), BOLD)}: {told}", "", *_parts(found, paint)]
    lines += ["", *layout.listed(_facts(found, plan), paint)]
    lines += ["", *_actions(found, paint)]
    lines += ["", *_habits(found, paint), *_outliers(found, paint)]
    for title, findings, code in (("remarks", remarks, YELLOW), ("problems", problems, RED)):
        lines += ["", paint(title, code)] if findings else []
        for finding in findings:
            first, *more = layout.wrapped(f"{finding.what}: {finding.where}", 4)
            first_step, *steps = layout.wrapped(finding.remedy, 6)
            lines += [f"  - {first}", *(f"    {line}" for line in more)]
            lines += [f"    → {first_step}", *(f"      {line}" for line in steps)]
    return "\n".join(lines) + "\n"


def _parts(found: Check, paint: Paint) -> list[str]:
    columns = ("clips", "frames", "hours", "sources", "persons", "windows", "short", "invalid")
    rows = [
        (
            part,
            *(words.count(row[name]) for name in ("clips", "frames")),
            f"{row['hours']:.2f}",
            *(words.count(row[name]) for name in ("sources", "persons", "windows", "short")),
            words.percent(row["invalid"]),
        )
        for part, row in found.parts.iterrows()
    ]
    head, *lines = layout.table([("part", *columns), *rows])
    return [paint(head, FAINT), *lines]


def _facts(found: Check, plan: dict[str, int]) -> dict[str, str]:
    channels = found.channels
    learnt = int(channels["learnt"].sum())
    left_out = channels[~channels["learnt"]]
    facts = {
        "training": f"{words.plural(plan['steps'], 'step')} of "
        f"{words.plural(plan['batch'], 'window')} of {words.plural(plan['window'], 'frame')}: "
        f"a training frame is seen about {words.number(found.seen)} times",
        "channels": f"{learnt} of {len(CHANNELS)} are learnt",
    }
    for why, own in left_out.groupby("why_not"):
        facts[str(why)] = ", ".join(own.index)
    if constant := list(channels.index[channels["constant"]]):
        facts["constant"] = ", ".join(constant)
    if found.rates:
        rates = sorted(found.rates.items())
        facts["frame rate"] = ", ".join(f"{rate} fps ({words.clips(n)})" for rate, n in rates)
    return facts


def _actions(found: Check, paint: Paint) -> list[str]:
    of = {part: own.set_index("action") for part, own in found.actions.groupby("part")}
    rows = [
        (
            action,
            ACTIONS[action].track,
            *(words.percent(of[part]["share"][action]) for part in PARTS),
            words.count(of["train"]["runs"][action]),
            words.count(of["train"]["clips"][action]),
        )
        for action in ACTIONS
    ]
    title = ("action", "track", *PARTS, "runs in train", "clips in train")
    head, *lines = layout.table([title, *rows])
    return [paint(head, FAINT), *lines, paint("  shares of the frames that measure it", FAINT)]


def _habits(found: Check, paint: Paint) -> list[str]:
    tied = found.habits[found.habits["phi"].abs() >= HABIT][:SHOWN]
    if tied.empty:
        told = f"  habits of training: none, no two actions are tied by {HABIT} or more"
        return [paint(told, FAINT)]
    rows = [
        (f"{h.action} and {h.other}", words.percent(h.together), f"{h.lift:.1f} ×", f"{h.phi:+.2f}")
        for h in tied.itertuples()
    ]
    head, *lines = layout.table([("habits of training", "together", "chance", "phi"), *rows])
    return [paint(head, FAINT), *lines]


def _outliers(found: Check, paint: Paint) -> list[str]:
    odd = found.channels[found.channels["outliers"] > 0]
    if odd.empty:
        return []
    odd = odd.sort_values("outliers", ascending=False, kind="stable")
    rows = [
        (name, words.count(c["outliers"]), _value(name, c["value"]), c["clip_id"], str(c["frame"]))
        for name, c in odd[:SHOWN].iterrows()
    ]
    head, *lines = layout.table([("outliers", "frames", "worst", "clip", "frame"), *rows])
    more = f"  and {words.plural(len(odd) - SHOWN, 'channel')} more: --json has all"
    return ["", paint(head, FAINT), *lines, *([paint(more, FAINT)] if len(odd) > SHOWN else [])]


def _value(channel: str, value: float) -> str:
    return f"{math.degrees(value):.0f}°" if CHANNELS[channel].unit == "rad" else f"{value:.2f}"

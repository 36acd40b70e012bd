"""What to do about a clip that a stage dropped or failed."""

import math
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from mimeline.clips.select import BESIDES
from mimeline.run import Run

DEFAULT = Path("results")
OVERLAP = "select.max_overlap"
# The key whose limit a clip broke, by stage and rule.
KEYS: dict[tuple[str, str], str] = {
    ("select", "too_short"): "select.min_s",
    ("select", "too_long"): "select.max_s",
    ("select", "too_small"): "select.min_side_px",
    ("select", "duplicate"): OVERLAP,
    ("fetch", "too_large"): "fetch.max_pixels",
    ("fetch", "too_many_bytes"): "fetch.max_mb",
    ("fetch", "too_long_source"): "fetch.max_source_s",
    ("fetch", "timed_out"): "fetch.timeout_s",
    ("ingest", "tracking_lost"): "ingest.max_missing",
    ("pose", "turned"): "pose.max_yaw_deg",
}
ASKABLE = ("select.", "pose.max_yaw_deg")  # what `mimeline funnel --set` can tell of
REMEDIES: dict[str, str] = {
    "excluded": "Take its line out of the list that select.exclusions names",
    "excluded_action": "Take the action out of select.excluded_actions",
    "condition": "Change select.conditions",
    "unsafe_id": "Give it a plain file name in the catalogue",
    "repeated_id": "Give each record an id of its own, if it is a clip of its own",
    "case_collision": "Rename one of the two: some disks hold them for one file",
    "bad_times": "Mend its times in the catalogue",
    "box_outside": "Mend its box in the catalogue",
    "unsafe_path": "Name a video under data_dir",
    "gone": "Where you have a copy of the video, put it into fetch.folder",
    "not_downloaded": "Install what downloads videos: pip install 'mimeline[download]'",
    "unreachable": "Wait, since it could not be had at the time",
    "no_tracking_result": "Put its tracking result into the tracker's folder, under its clip_id",
    "tracking_loss": "Track it again, or raise ingest.max_loss or ingest.max_reprojection",
    "split_gap": "Lower split.gap_s, or add sources: with three and more there is no gap",
    "near_duplicate": "It repeats a clip of another part; split.near_duplicates: null keeps it",
}
# What a stage tries anew only where it is told to run again.
FORCING = {("fetch", rule) for rule in ("unreadable", "unreachable", "not_downloaded", "gone")}
ELSE = "Do what it says"


@dataclass(frozen=True)
class Step:
    """What to do, and the command that goes with it."""

    say: str
    command: str


def remedy(
    stage: str, rule: str, value: float | None, detail: str | None, results: Path, run: Run
) -> list[Step]:
    """What to do, step by step.

    value, detail: what the ledger says of the clip. run: the one that made the results.
    """
    key = KEYS.get((stage, rule))
    changed: dict[str, Any] = {}
    if key and key != OVERLAP and value is not None and math.isfinite(value):
        changed[key] = _beyond(value, down=key.startswith("select.min"))
    if key == OVERLAP or BESIDES in (detail or ""):
        changed[OVERLAP] = None  # the last: a clip breaks another rule first
    if key in changed:
        steps = [_changing(changed, run)]
        if all(key.startswith(ASKABLE) for key in changed):
            steps.append(Step("What else that keeps:", asking(results, changed)))
        return steps
    do = REMEDIES.get(rule, ELSE)
    if key:
        do = f"Change {key} in {'--config' if _given(run, key) else run.file}"
    if OVERLAP in changed:
        do += f", and set {OVERLAP} to null in {run.file}, for it is a duplicate as well"
    options = ("--forcerun", stage) if (stage, rule) in FORCING else ()
    return [Step(f"{do}, then type:", run.command(*options))]


def asking(results: Path, changed: dict[str, Any]) -> str:
    """The command that tells what other values of these keys would keep."""
    words = ["mimeline", "funnel", *named(results)]
    for key, value in changed.items():
        words += ["--set", f"{key}={_written(value)}"]
    return shlex.join(words)


def named(results: Path) -> list[str]:
    """The option that names a run's results, where they are not where everybody looks."""
    return [] if Path(results) == DEFAULT else ["--results", str(results)]


def _changing(changed: dict[str, Any], run: Run) -> Step:
    """How to give keys other values: in the file, or where --config told one, there."""
    both = OVERLAP in changed and len(changed) > 1
    if any(_given(run, key) for key in changed):
        sections: dict[str, dict[str, Any]] = {}
        for key, value in changed.items():
            section, name = key.split(".")
            sections.setdefault(section, {})[name] = value
        told = "It is a duplicate as well: type" if both else "Type"
        return Step(f"{told} this instead:", run.command(**sections))
    as_well = " (it is a duplicate as well)" if both else ""
    told = " and ".join(f"{key} to {_written(value)}" for key, value in changed.items())
    return Step(f"Set {told} in {run.file}{as_well}, then type again:", run.command())


def _given(run: Run, key: str) -> bool:
    """Whether --config told the key: it stands over every file."""
    section, name = key.split(".")
    told = [text.partition("=")[2] for text in run.given if text.startswith(f"{section}=")]
    return any(isinstance(keys := yaml.safe_load(text), dict) and name in keys for text in told)


def _written(value: Any) -> str:
    return "null" if value is None else f"{value:.10g}"


def _beyond(value: float, down: bool) -> float | int:
    """A limit of few digits that the value does not break."""
    scale = 10.0 if value >= 10 else 1000.0
    limit = (math.floor if down else math.ceil)(round(value * scale, 6)) / scale
    return int(limit) if limit.is_integer() else limit

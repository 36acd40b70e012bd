"""The firewall: what a take says against itself becomes a ledger row, or stops the run."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mimeline.config.trackers import Ingest
from mimeline.errors import BadFile, MimelineError
from mimeline.tracking.detectors import (
    Finding,
    angle_unit,
    dead_channels,
    eyes_disagree,
    eyes_that_move,
    frozen,
    heads,
    misnumbered,
    numbers_of,
    out_of_range,
    pairs,
    sides_swapped,
    still,
)
from mimeline.tracking.take import Take
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

FEWEST_TAKES = 3  # that show the same fault, before the set-up is blamed
FEWEST_CHANNELS = 10  # that may all be exactly 0 by no chance; two eyelids may


def examine(take: Take, first_frame: int | None = None) -> list[Finding]:
    """What the detectors find in a take, at most one finding of a rule, those that fail first.

    first_frame: of the format's Convention.
    """
    findings: list[Finding | None] = [misnumbered(take, first_frame)]
    if take.motion["valid"].any():
        for detector in (sides_swapped, eyes_disagree, angle_unit):
            findings += detector(take)
        findings += [detector(take) for detector in (still, dead_channels, frozen, out_of_range)]
    found: dict[str, Finding] = {}
    for finding in filter(None, findings):
        found.setdefault(finding.rule, finding)
    return sorted(found.values(), key=lambda finding: finding.severity)


def tells(take: Take) -> frozenset[str]:
    """The failing rules that this take moves enough to answer, whatever the answer is."""
    rules = set()
    if any(True for _ in pairs(take)):
        rules.add("sides_swapped")
    if any(True for _ in eyes_that_move(take)):
        rules.add("eyes_disagree")
    if heads(take) or "sides_swapped" in rules:
        rules.add("angle_unit")
    return frozenset(rules)


def of_the_set_up(shown: int, could: int) -> bool:
    """Whether a fault is no take's own: three takes show it at least, and most of those that could.

    shown, could: numbers of takes, or of sources.
    """
    return shown >= FEWEST_TAKES and 2 * shown > could


def systemic(
    found: Mapping[str, list[Finding]],
    able: Mapping[str, frozenset[str]],
    folder: Path,
    format: str,
) -> MimelineError | None:
    """The error to stop with, where it is the set-up that is at fault and not a take.

    found: take → examine(take). able: take → tells(take). folder: the tracker's. format: its name.
    A take is a tracking result, however many clips are cut out of it: it shows, and tells, what any
    of them does.
    """
    for rule in ("angle_unit", "sides_swapped", "eyes_disagree"):
        shown = {
            name: finding
            for name, findings in found.items()
            for finding in findings
            if finding.rule == rule and finding.severity == "fail"
        }
        could = sum(rule in rules for rules in able.values())
        if not of_the_set_up(len(shown), could):
            continue
        name, finding = next(iter(shown.items()))
        return BadFile(
            folder,
            place=f"{len(shown)} of the {could} takes that can tell",
            found=f"{rule}: in {name}, {finding.detail}",
            expected=f"takes of {format} that agree with themselves",
            remedy=_remedy(rule, format),
        )
    return None


def unreadable_alike(
    errors: Mapping[str, MimelineError], n_takes: int, folder: Path
) -> MimelineError | None:
    """The error to stop with, where most of n_takes cannot be read for one and the same
    reason, which a key of the configuration mends.

    errors: take → what its reader refused it for, each take once, however many clips it has.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for name, error in errors.items():
        if "ingest." in error.remedy and "bad_values" not in error.remedy:  # cells are a file's own
            alike.setdefault((error.expected, error.remedy), []).append(name)
    for (expected, remedy), names in alike.items():
        if of_the_set_up(len(names), n_takes):
            first = errors[names[0]]
            return BadFile(
                folder,
                place=f"{len(names)} of {n_takes} takes",
                found=f"{first.found} (in {Path(first.file).name})",
                expected=expected,
                remedy=remedy,
            )
    return None


def _remedy(rule: str, format: str) -> str:
    block = Ingest.model_fields[format].annotation.model_fields
    if rule == "angle_unit" and "angle_unit" in block:
        return f"Set ingest.{format}.angle_unit to the other unit."
    if format == "table":
        return "Correct the columns and scales in ingest.table.channels."
    return "Correct ingest.format, or name columns, signs and unit yourself: ingest.format: table."


def lost_frames(take: Take) -> np.ndarray:
    """Frames (n,) bool that are valid but whose expressions are all exactly 0: no face was found.

    Trackers measure noise, so a face at rest is never 0 throughout. A take that is 0 in most
    channels of its other frames, too, was made rather than measured, or holds few channels that
    are often 0 (action units): there a row of zeros means a face at rest.
    """
    valid = take.motion["valid"].to_numpy()
    values = numbers_of(take, EXPRESSIONS)
    values = values[:, ~np.isnan(values).all(axis=0)]
    if values.shape[1] < FEWEST_CHANNELS:
        return np.zeros(len(valid), bool)
    zero = valid & (values == 0).all(axis=1)
    others = values[valid & ~zero]
    if not len(others) or np.median((others == 0).mean(axis=1)) >= 0.5:
        return np.zeros(len(valid), bool)
    return zero


def without_lost(take: Take) -> Take:
    """The take with its lost frames not valid, and without numbers."""
    lost = lost_frames(take)
    if not lost.any():
        return take
    motion = take.motion.assign(valid=take.motion["valid"] & ~lost)
    motion.loc[lost, list(CHANNELS)] = np.nan
    coefficients = {
        name: rows[~lost].reindex(rows.index) for name, rows in take.coefficients.items()
    }
    return replace(take, motion=motion, coefficients=coefficients)

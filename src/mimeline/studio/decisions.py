"""What people decided on clips: the list of those left out, and which were looked at."""

import os
import threading
from dataclasses import dataclass
from pathlib import Path

from mimeline.atomic import whole
from mimeline.clips.exclusions import COLUMNS, read_exclusions, write_exclusions
from mimeline.errors import BadFile, unreadable
from mimeline.studio.watched import Stamp, alone, is_tidy, revision, stamp, unwritten

MOST_CHARACTERS = 200  # of a reason


@dataclass(frozen=True)
class Decision:
    """On one clip: whether it was looked at, and why it is left out; None where it is not."""

    seen: bool = False
    reason: str | None = None


class Decisions:
    """The list of exclusions and, beside it, the ids that were looked at; the files are the truth.

    exclusions: the CSV, which need not be there yet. Each decision is on disk when `decide`
    returns. What others write into the files meanwhile is read before each decision, and kept.
    Raises BadFile for a list that cannot be read, or has columns that would be lost.
    """

    def __init__(self, exclusions: str | Path):
        self.exclusions = Path(os.path.realpath(exclusions))  # a link stays one
        self.looked_at = self.exclusions.with_name(f"{self.exclusions.stem}.seen.txt")
        self.reasons: dict[str, str] = {}
        self.seen: set[str] = set()
        self._stamps: dict[Path, Stamp] = {}
        self._lock = threading.Lock()
        self.refresh()

    @property
    def revision(self) -> str:
        """Another text whenever a file is another."""
        return revision(self._stamps.get(path) for path in (self.exclusions, self.looked_at))

    def of(self, clip_id: str) -> Decision:
        return Decision(clip_id in self.seen, self.reasons.get(clip_id))

    def refresh(self) -> None:
        """Read what has changed on disk since."""
        with self._lock:
            self._refresh()

    def decide(self, clip_id: str, was: Decision, now: Decision) -> tuple[Decision, str]:
        """Write a decision; was: what the person saw when deciding.

        Returns what holds, it or what somebody else decided meanwhile, and the revision before.
        """
        with self._lock, alone(self.exclusions):
            self._refresh()
            held, before = self.of(clip_id), self.revision
            if held not in (was, now):
                return held, before
            if now.reason != held.reason:  # first, as it is the one that must not be lost
                self._write_reason(clip_id, now.reason)
            if now.seen != held.seen:
                self._write_seen(clip_id, now.seen)
            return now, before

    def _refresh(self) -> None:
        for path, read in (
            (self.exclusions, self._read_reasons),
            (self.looked_at, self._read_seen),
        ):
            now = stamp(path)
            if path not in self._stamps or now != self._stamps[path]:
                read(absent=now is None)
                self._stamps[path] = now

    def _read_reasons(self, absent: bool) -> None:
        if not absent:
            reasons = read_exclusions(self.exclusions)
            _refuse_other_columns(self.exclusions)
        self.reasons = {} if absent else reasons

    def _read_seen(self, absent: bool) -> None:
        try:
            text = "" if absent else self.looked_at.read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            remedy = "Delete it: only which clips were looked at is forgotten."
            raise unreadable(
                self.looked_at, error, expected="an id per line", remedy=remedy
            ) from error
        self.seen = {line for line in text.split("\n") if line}

    def _write_reason(self, clip_id: str, reason: str | None) -> None:
        others = {name: text for name, text in self.reasons.items() if name != clip_id}
        reasons = others if reason is None else others | {clip_id: reason}
        try:
            write_exclusions(self.exclusions, reasons)
        except OSError as error:
            raise unwritten(self.exclusions, error) from error
        self.reasons, self._stamps[self.exclusions] = reasons, stamp(self.exclusions)

    def _write_seen(self, clip_id: str, seen: bool) -> None:
        ids = self.seen | {clip_id} if seen else self.seen - {clip_id}
        try:
            with whole(self.looked_at) as temporary:
                temporary.write_text("".join(f"{name}\n" for name in sorted(ids)), encoding="utf-8")
        except OSError as error:
            raise unwritten(self.looked_at, error) from error
        self.seen, self._stamps[self.looked_at] = ids, stamp(self.looked_at)


def fits(reason: str) -> bool:
    """Whether a reason may stand in the list."""
    return is_tidy(reason, MOST_CHARACTERS)


def _refuse_other_columns(path: Path) -> None:
    with open(path, encoding="utf-8-sig") as file:
        header = file.readline().replace(";", ",").replace("\t", ",")
    names = [name.strip().strip('"') for name in header.split(",")]
    if others := [name for name in names if name and name not in COLUMNS]:
        raise BadFile(
            path,
            found=f"also the columns {', '.join(others)}",
            expected="clip_id and reason alone, as the file is written anew",
            remedy="Keep a copy of the other columns and take them out, or give --exclusions "
            "another file.",
        )

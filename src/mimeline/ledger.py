"""The ledger: what was decided on each clip at a stage, and the law that no clip is lost."""

import logging
from collections import Counter
from collections.abc import Collection, Iterable
from pathlib import Path

import pandas as pd

from mimeline import tables

TOLD = 3  # failed clips that the log names


class Ledger:
    """Collects one stage's decisions, exactly one per clip that came in.

    A dropped clip broke a rule; a failed one could not be processed; every other clip is kept. A
    clip that is dropped or failed has one row, which says why; one that is kept has a row for each
    note, or one without a rule.
    """

    def __init__(self, stage: str, clips: Iterable[str]):
        self.stage = stage
        self.rows: dict[str, dict] = {clip: self._row(clip, "kept") for clip in clips}
        self._notes: dict[str, dict[str, dict]] = {clip: {} for clip in self.rows}

    def _row(self, clip_id: str, status: str, **facts) -> dict:
        row = dict.fromkeys(tables.LEDGER.schema.names)
        return row | {"clip_id": clip_id, "stage": self.stage, "status": status} | facts

    def drop(self, clip_id: str, rule: str, **facts) -> None:
        """The clip broke a rule. facts: value, limit, unit, first_frame, last_frame, detail."""
        self._decide(clip_id, "dropped", rule, facts)

    def fail(self, clip_id: str, rule: str, **facts) -> None:
        """The clip could not be processed. facts: as for drop."""
        self._decide(clip_id, "failed", rule, facts)

    def note(self, clip_id: str, rule: str, **facts) -> None:
        """If the clip is kept, the ledger says this of it (as a rule that did not apply).

        Of two notes of one rule the later one counts.
        """
        self._require(clip_id)
        self._notes[clip_id][rule] = self._row(clip_id, "kept", rule=rule, **facts)

    def _decide(self, clip_id: str, status: str, rule: str, facts: dict) -> None:
        self._require(clip_id)
        if self.rows[clip_id]["status"] != "kept":
            raise AssertionError(f"{self.stage} decides twice on {clip_id}")
        self.rows[clip_id] = self._row(clip_id, status, rule=rule, **facts)

    def _require(self, clip_id: str) -> None:
        if clip_id not in self.rows:
            raise AssertionError(f"{self.stage} decides on {clip_id}, which never came in")

    @property
    def kept(self) -> list[str]:
        """The clips that go on."""
        return [clip for clip, row in self.rows.items() if row["status"] == "kept"]

    def close(self, path: str | Path, kept: Collection[str]) -> None:
        """Write the decisions; kept are the clips that the stage hands on.

        Raises AssertionError unless clips in = kept + dropped + failed.
        """
        if sorted(kept) != sorted(self.kept):
            lost = set(self.kept) ^ set(kept)
            raise AssertionError(f"{self.stage}: no decision explains the clips {sorted(lost)}")
        rows = []
        for clip, row in self.rows.items():
            noted = self._notes[clip] if row["status"] == "kept" else {}
            rows += noted.values() or [row]
        tables.write(tables.LEDGER, pd.DataFrame(rows, columns=tables.LEDGER.schema.names), path)

    def tell(self, log: logging.Logger) -> None:
        """Log the counts, and of the first clips that failed, why."""
        log.info("%s", self)
        failed = [row for row in self.rows.values() if row["status"] == "failed"]
        for row in failed[:TOLD]:
            log.warning("%s %s: %s", row["clip_id"], row["rule"], row["detail"])
        if len(failed) > TOLD:
            more = len(failed) - TOLD
            log.warning(
                "and %d more: mimeline funnel counts them, mimeline why tells of each", more
            )

    def __str__(self) -> str:
        statuses = Counter(row["status"] for row in self.rows.values())
        rules = Counter(r["rule"] for r in self.rows.values() if r["status"] != "kept")
        text = f"{len(self.rows)} clips in, {statuses['kept']} kept"
        text += f", {statuses['dropped']} dropped, {statuses['failed']} failed"
        reasons = ", ".join(f"{rule} {count}" for rule, count in rules.most_common())
        return f"{text} ({reasons})" if reasons else text

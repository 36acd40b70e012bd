"""What is found against clips: the first rule that each breaks, and rules that do not apply."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

FACTS = ("rule", "value", "limit", "unit", "detail")
NOTHING = {"rule": None, "value": np.nan, "limit": np.nan, "unit": None, "detail": None}

# Tells the details of the clips in these rows (m,).
Details = Callable[[np.ndarray], Sequence[str]]


class Findings:
    """Of n clips, by their rows. A rule is asked of those alone that no rule before it dropped."""

    def __init__(self, clip_ids: pd.Series):
        self.clip_ids = clip_ids.to_numpy(object)
        self._dropped = {name: np.full(len(clip_ids), none) for name, none in NOTHING.items()}
        self._notes: list[pd.DataFrame] = []

    @property
    def free(self) -> np.ndarray:
        """Those that no rule has dropped, (n,) bool."""
        return np.equal(self._dropped["rule"], None)

    def drop(
        self,
        rule: str,
        broken: Sequence[bool],
        values: np.ndarray | None = None,
        limit: float = np.nan,
        unit: str | None = None,
        details: Details | None = None,
    ) -> None:
        """The rule drops those that break it. broken: (n,). values: (n,), in the unit."""
        rows = np.flatnonzero(np.asarray(broken, bool) & self.free)
        told = {"rule": rule, "limit": limit, "unit": unit}
        told |= {} if values is None else {"value": values[rows]}
        told |= {} if details is None else {"detail": list(details(rows))}
        for name, fact in told.items():
            self._dropped[name][rows] = fact

    def note(
        self,
        rule: str,
        where: Sequence[bool],
        details: Details,
        limit: float = np.nan,
        unit: str | None = None,
    ) -> None:
        """The rule could not be applied there; of two details of a rule, both are told."""
        rows = np.flatnonzero(np.asarray(where, bool) & self.free)
        told = NOTHING | {"rule": rule, "limit": limit, "unit": unit, "detail": details(rows)}
        self._notes.append(pd.DataFrame({"clip_id": self.clip_ids[rows], "status": "kept"} | told))

    def add(self, rows: np.ndarray, details: Sequence[str]) -> None:
        """One more detail of clips that a rule has dropped."""
        held = self._dropped["detail"]
        for row, detail in zip(rows, details, strict=True):
            held[row] = f"{held[row]}; {detail}" if held[row] else detail

    def table(self) -> pd.DataFrame:
        """clip_id, status and FACTS: a row for each dropped clip, and for each note on another."""
        dropped = pd.DataFrame({"clip_id": self.clip_ids, "status": "dropped"} | self._dropped)
        notes = pd.concat([dropped.iloc[:0], *self._notes])
        notes = notes[notes["clip_id"].isin(self.clip_ids[self.free])]
        again = notes.duplicated(["clip_id", "rule"], keep=False)
        joined = dict.fromkeys(notes, "first") | {"detail": "; ".join}
        twice = notes[again].groupby(["clip_id", "rule"], sort=False).agg(joined)
        parts = (dropped[~self.free], notes[~again], twice)
        return pd.concat([part.astype(object) for part in parts], ignore_index=True)

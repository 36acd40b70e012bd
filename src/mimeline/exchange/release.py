"""What goes with a data set, of whatever layout: whose it is, what it lost, how it was had."""

import csv
import json
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from mimeline import __version__
from mimeline.exchange.contents import Contents
from mimeline.exchange.finished import Finished
from mimeline.exchange.licences import DataSet, as_json
from mimeline.reporting import words
from mimeline.vocabulary import CHANNELS, DEAD_RANGE

ABOUT, CHANNEL_TABLE, LEFT_OUT = "about.json", "channels.csv", "left_out.csv"
_DIGITS = "%.6g"


@dataclass(frozen=True)
class Release:
    """A data set that was written.

    sets: whose recordings. contact: whom people may ask that are in them; empty: not told.
    channels: those that it has. left_out: clips of the run's parts that it has not, clip_id, part,
    reason and detail. notes: what else its user should hear.
    """

    run: Finished
    sets: tuple[DataSet, ...]
    contact: str
    contents: Contents
    channels: list[str]
    left_out: list[dict[str, str]] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        return f"Facial-action timelines of {words.listing([own.name for own in self.sets])}"

    @property
    def missing(self) -> list[str]:
        """What the user has not told and a reader of the card has to know."""
        told = [f"the consent of the people in {o.name}" for o in self.sets if not o.consent]
        told += [f"the licence of {own.name}" for own in self.sets if not own.licence]
        personal = any(own.personal for own in self.sets)
        return [*told, *(["a contact"] if personal and not self.contact else [])]

    @property
    def against(self) -> list[DataSet]:
        """What the user passes on although it is not known to be permitted."""
        return [own for own in self.sets if own.redistribution != "permitted"]

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row per channel, by its name: what `channels.csv` holds."""
        told = self.run.channels.drop(columns=["measured", "share"])
        given = pd.DataFrame(
            {
                "kind": {name: own.kind for name, own in CHANNELS.items()},
                "unit": {name: own.unit for name, own in CHANNELS.items()},
                "mirror": {name: own.mirror for name, own in CHANNELS.items()},
                "mirror_sign": {name: own.mirror_sign for name, own in CHANNELS.items()},
                "exported": {name: name in self.channels for name in CHANNELS},
                "measured": {name: self.contents.having(name) for name in CHANNELS},
            }
        )
        return given.join(told)

    @property
    def mapped(self) -> pd.DataFrame:
        """The exported channels that a face model gave, the least reliable first."""
        own = self.table[self.table["exported"] & self.table["quality"].notna()]
        return own.sort_values("quality", kind="stable")

    @property
    def still(self) -> list[str]:
        """The exported channels that hardly move."""
        own = self.table[self.table["exported"]]
        return list(own.index[own["high"] - own["low"] < DEAD_RANGE])

    @property
    def why_not(self) -> dict[str, list[str]]:
        """Reason → the channels that are not exported for it."""
        own = self.table[~self.table["exported"]]
        reasons = own["origin"].where(~self.run.channels["measured"], "measured in too few frames")
        groups = reasons.fillna("not measured").groupby(reasons.fillna("not measured"), sort=False)
        return {str(reason): list(rows.index) for reason, rows in groups}

    def write_tables(self, folder: Path) -> None:
        """Write what programs read of it: about.json, channels.csv and, if any, left_out.csv."""
        text = json.dumps(self._about(), indent=1, ensure_ascii=False, allow_nan=False)
        (folder / ABOUT).write_text(text + "\n", encoding="utf-8")
        self.table.to_csv(
            folder / CHANNEL_TABLE, index_label="channel", float_format=_DIGITS, lineterminator="\n"
        )
        if self.left_out:
            with open(folder / LEFT_OUT, "w", encoding="utf-8", newline="") as file:
                rows = csv.DictWriter(file, list(self.left_out[0]), lineterminator="\n")
                rows.writeheader()
                rows.writerows(self.left_out)

    def _about(self) -> dict[str, Any]:
        return {
            "mimeline": __version__,
            "config_digest": self.run.config_digest or None,
            "data_sets": [as_json(own) for own in self.sets],
            "contact": self.contact or None,
            "parts": [
                {"part": p.name, "clips": p.clips, "frames": p.frames, "seconds": p.seconds}
                for p in self.contents.parts[:-1]
            ],
            "rates": [str(fps) for fps in self.contents.rates],
            "funnel": [
                {
                    "stage": stage.name,
                    "in": stage.entered,
                    "kept": stage.kept,
                    "dropped": stage.dropped,
                    "failed": stage.failed,
                    "reasons": dict(stage.reasons),
                }
                for stage in self.run.stages
            ],
            "left_out_of_this_export": len(self.left_out),
        }

"""What the label page shows to a person: the run's clusters with that person's answers on them."""

import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from mimeline.annotation.agreement import agreement
from mimeline.annotation.label_file import Answer, RegionAnswers
from mimeline.annotation.queries import worth
from mimeline.reporting import words
from mimeline.reporting.style import colours, readable_on
from mimeline.studio.answers import FIRST, Answers, Persons
from mimeline.studio.clusters_of_run import ClustersOfRun, Region
from mimeline.vocabulary import ACTIONS, NEUTRAL, series_actions

DARK = 1  # the page's theme, of style's two
_ACTION = re.compile(rf"\b({'|'.join([*ACTIONS, NEUTRAL])})\b")


class Labelling:
    """Of a second person nothing is told of proposals where they have not answered yet."""

    def __init__(self, run: ClustersOfRun, persons: Persons):
        self.run, self.persons = run, persons

    def clusters(self) -> Iterator[tuple[str, int]]:
        """Every cluster of the run, as (region, number)."""
        for region in self.run.regions.values():
            yield from ((region.name, int(n)) for n in region.proposed.index)

    def state(self, person: str) -> dict[str, Any]:
        """All that the page shows but the exemplars."""
        answers, rows = self.persons.of(person), self._rows(person)
        return {
            "results": str(self.run.results),
            "file": str(self.persons.path(person)),
            "person": person,
            "persons": list(dict.fromkeys([*self.persons.names(), person])),
            "revision": answers.revision,
            "command": command(self) if person == FIRST else "",
            "regions": [
                self._region(region, answers, person, rows) for region in self.run.regions.values()
            ],
            "next": self._next(answers, rows),
        }

    def next(self, person: str) -> list[list]:
        """Clusters without an answer, as [region, number].

        First those that no name could be moved to, then the worthier.
        """
        return self._next(self.persons.of(person), self._rows(person))

    def agreement(self, person: str) -> dict[str, Any]:
        """Of the first and another person, over the clusters that both named."""
        whose = (FIRST, person) if person != FIRST else ()
        first, second = [self._fresh(who) for who in whose] or ({}, {})
        found = agreement(first, second, self._proposed())
        return {
            "kappa": _number(found.kappa),
            "kappa_frames": _number(found.kappa_frames),
            "same": _number(found.same),
            "n": found.n,
            "differing": [
                {
                    "region": region,
                    "cluster": int(cluster),
                    "first": as_json(first[region].clusters[cluster]),
                    "second": as_json(second[region].clusters[cluster]),
                }
                for region, cluster in found.differing
            ],
        }

    def _next(self, answers: Answers, rows: pd.DataFrame) -> list[list]:
        unsafe = [r.cluster in answers.unsafe(r.region) for r in rows.itertuples()]
        none = [answers.of(r.region, r.cluster) is None for r in rows.itertuples()]
        rows = rows.assign(unsafe=unsafe)[np.logical_or(unsafe, none)]
        rows = rows.sort_values(["unsafe", "worth"], ascending=False, kind="stable")
        return [[r.region, int(r.cluster)] for r in rows.itertuples()]

    def _fresh(self, person: str) -> dict[str, RegionAnswers]:
        answers = self.persons.of(person)
        answers.refresh()
        return answers.written()

    def _region(
        self, region: Region, answers: Answers, person: str, rows: pd.DataFrame
    ) -> dict[str, Any]:
        own = rows[rows["region"] == region.name].set_index("cluster")
        moved = None
        if len(region.proposed) and (settled := answers.settled(region.name)).kept is not None:
            moved = {"kept": settled.kept, "known": settled.known}
        return {
            "name": region.name,
            "fit": region.fingerprint,
            "channels": list(region.channels),
            "left_out": list(region.left_out),
            "unmeasured": region.unmeasured,
            "reason": region.reason,
            "top": region.top,
            "moved": moved,
            "actions": [_action(name, key) for name, key in _keys(region.name)],
            "clusters": [
                self._cluster(region, int(n), answers, person, float(own.loc[n, "worth"]))
                for n in region.proposed.index
            ],
        }

    def _cluster(
        self, region: Region, number: int, answers: Answers, person: str, worth: float
    ) -> dict[str, Any]:
        settled, answer = answers.settled(region.name), answers.of(region.name, number)
        told = person == FIRST or answer is not None
        facts = self.run.facts(region.name, number)
        proposed = region.proposed.loc[number]
        return facts | {
            "purity": facts["purity"] if told else None,
            "proposed": {
                "action": _text(proposed["action"]),
                "confidence": _number(proposed["confidence"]),
                "why": _plain(_text(proposed["why"]) or ""),
            }
            if told
            else None,
            "answer": as_json(answer),
            "agreement": settled.moved.get(number),
            "unsafe": _plain(answers.unsafe(region.name).get(number, "")),
            "worth": worth,
            "n_shown": len(answers.shown(region.name, number)),
        }

    def _proposed(self) -> pd.DataFrame:
        return pd.concat(
            [r.proposed for r in self.run.regions.values() if len(r.proposed)], ignore_index=True
        )

    def _rows(self, person: str) -> pd.DataFrame:
        """The `labels` table as the person's answers have it, and what a look is worth.

        Of a second person it is blind: without proposals.
        """
        answers, rows = self.persons.of(person), self._proposed()
        if person != FIRST:
            rows = rows.assign(action=None, confidence=math.nan)
        columns = ["action", "confidence", "source"]
        for row in rows.itertuples():
            answer = answers.named(row.region, row.cluster)
            moved = answers.settled(row.region).moved.get(row.cluster)
            if answer is not None:
                told = (math.nan, "human") if moved is None else (moved, "moved")
                rows.loc[row.Index, columns] = [answer.action, *told]
        return rows.assign(worth=worth(rows))


def command(labelling: Labelling) -> str:
    """What runs with the names, up to the timelines."""
    file = {"file": str(labelling.persons.file)}
    return labelling.run.run.command("--until", "annotate", label=file)


def as_json(answer: Answer | None) -> dict[str, Any] | None:
    if answer is None:
        return None
    return {"action": answer.action, "note": answer.note, "same_as": answer.same_as}


def _keys(region: str) -> list[tuple[str, str]]:
    actions = series_actions(region)
    return [*((name, str(n)) for n, name in enumerate(actions, start=1)), (NEUTRAL, "0")]


def _action(name: str, key: str) -> dict[str, str]:
    colour = colours()[name][DARK]
    told = {"name": name, "words": words.spaced(name).capitalize(), "key": key}
    return told | {"colour": colour, "on": readable_on(colour)}


def _plain(text: str) -> str:
    """A reason with its actions and shares as the page writes them."""
    text = _ACTION.sub(lambda found: words.spaced(found[0]), text)
    return re.sub(r"(\d)%", r"\1 %", text)


def _number(value) -> float | None:
    return None if pd.isna(value) or not math.isfinite(value) else float(value)


def _text(value) -> str | None:
    return None if pd.isna(value) else str(value)

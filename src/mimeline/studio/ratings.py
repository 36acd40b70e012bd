"""What people answered about the pairs of a study, with intervals, beside the published numbers.

The share that agrees is that of Ma et al. 2025 ("User Study", Fig. 9): answers of agree or strongly
agree among all, "don't know" among them.
"""

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np

from mimeline.errors import BadFile
from mimeline.inspection.layout import table, wrapped
from mimeline.reporting import words
from mimeline.studio.rating_file import QUESTIONS, UNSEEN, Rating, read_ratings
from mimeline.studio.timelines_of_run import KINDS, MISMATCHED
from mimeline.vocabulary import resource

AGREES, UNSURE = 4, 3  # the least answer that agrees; "don't know"
RESAMPLES, SEED = 2000, 0
LEAST_TELLING = 3  # mismatched pairs; of fewer nothing is said about a person
PAPER = "Ma et al."


@dataclass(frozen=True)
class Share:
    """The answers to a question on pairs of a kind, in one view.

    agree: share of the answers, [low, high] its 95 % interval; over: what was resampled for it,
    "persons and pairs", "pairs" or "persons"; "exact" where all answers are alike, which says
    nothing to a bootstrap; none of one answer. mean: of the five points. paper: the share
    that the paper has, None where it has none.
    """

    kind: str
    question: str
    view: str
    answers: int
    persons: int
    pairs: int
    agree: float
    low: float | None
    high: float | None
    over: str
    mean: float
    unsure: float
    paper: float | None


@dataclass(frozen=True)
class Person:
    """How many pairs a person answered, how long they took in the median (None of none), with how
    many of the mismatched they agreed, and of how many pairs there was no picture."""

    name: str
    pairs: int
    median_s: float | None
    mismatched: int
    agreed: int
    unseen: int

    @property
    def looks(self) -> bool:
        """Whether they tell a timeline from another's, as far as is known."""
        return self.mismatched < LEAST_TELLING or 2 * self.agreed < self.mismatched


@dataclass(frozen=True)
class Ratings:
    """results: the fingerprint of the run that was judged. pairs: how many different ones were.
    Pairs without a picture count nowhere but in `unseen`."""

    results: str
    pairs: int
    shares: tuple[Share, ...]
    persons: tuple[Person, ...]


def ratings(files: Sequence[str | Path], resamples: int = RESAMPLES, seed: int = SEED) -> Ratings:
    """What all the files say together.

    files: of `mimeline rate`, of one run's results. resamples: of persons and pairs, behind each
    interval. Raises BadFile, with the line, for what is no such file; where two hold answers about
    different results, or one person's answer twice; where there is none.
    """
    rows: dict[tuple, tuple[Rating, str | Path]] = {}
    for file in files:
        for rating in read_ratings(file):
            first, before = next(iter(rows.values()), (rating, file))
            if rating.results != first.results:
                raise BadFile(
                    file,
                    found=f"answers about other results ({rating.results})",
                    expected=f"about those of {before} ({first.results})",
                    remedy="What was asked is not the same: look at the files one by one.",
                )
            if rating.key in rows:
                other = rows[rating.key][1]
                raise BadFile(
                    file,
                    found=f"an answer of {rating.person} that {other} has as well",
                    expected="each answer once",
                    remedy="Give one of the two, or, of two people, rename one in the file.",
                )
            rows[rating.key] = rating, file
    everything = [rating for rating, _ in rows.values()]
    given = [rating for rating in everything if rating.answer != UNSEEN]
    if not given:
        raise BadFile(
            ", ".join(map(str, files)),
            found="no answer",
            expected="answers of one person at least",
            remedy="Answer some with mimeline rate.",
        )
    rng = np.random.default_rng(seed)
    return Ratings(
        given[0].results,
        len({rating.pair for rating in given}),
        tuple(_shares(given, resamples, rng)),
        tuple(_persons(everything)),
    )


def interval(
    agrees: np.ndarray, answered: np.ndarray, resamples: int, rng: np.random.Generator
) -> tuple[float | None, float | None, str]:
    """95 % interval of the share that agrees, and what was resampled for it.

    agrees, answered: (persons, pairs) bool. Persons and pairs are drawn apart and crossed (Owen
    2007, "The pigeonhole bootstrap"), as both are a sample: other people, and other clips, would
    have answered otherwise. Where all answers are alike that would be a single point: then the
    exact interval (Clopper and Pearson 1934) is given, of as many answers as there are pairs.
    """
    persons, pairs = answered.shape
    if answered.sum() < 2:
        return None, None, ""
    share = agrees[answered].mean()
    if share in (0, 1):
        n = pairs if pairs > 1 else persons
        reach = 0.025 ** (1 / n)
        return (reach, 1.0, "exact") if share else (0.0, 1 - reach, "exact")
    of_persons = _drawn(persons, resamples, rng)  # (resamples, persons)
    of_pairs = _drawn(pairs, resamples, rng)  # (resamples, pairs)
    hits = ((of_persons @ (agrees & answered)) * of_pairs).sum(axis=1)  # (resamples,)
    total = ((of_persons @ answered) * of_pairs).sum(axis=1)  # (resamples,)
    shares = hits[total > 0] / total[total > 0]
    low, high = np.quantile(shares, [0.025, 0.975])
    over = [name for name, n in (("persons", persons), ("pairs", pairs)) if n > 1]
    return float(low), float(high), " and ".join(over)


def as_text(found: Ratings) -> str:
    """What a person reads."""
    views = sorted({share.view for share in found.shares})
    told = {"film": "films", "face": "drawn faces"}
    n = len(found.persons)
    lines = [
        f"{n} {'person' if n == 1 else 'persons'}, {found.pairs} pairs of results {found.results}, "
        f"seen as {words.listing([told[view] for view in views])}"
    ]
    for question, text in QUESTIONS.items():
        own = [share for share in found.shares if share.question == question]
        if own:
            lines += ["", f"{question}: “{text}”", *_table(own, len(views) > 1)]
    lines += ["", "persons", *_persons_table(found.persons), "", *_notes(found)]
    return "\n".join(lines) + "\n"


def as_json(found: Ratings) -> str:
    """What a program reads: shares of 1."""
    held = asdict(found)
    for told, person in zip(held["persons"], found.persons, strict=True):
        told["looks"] = person.looks
    return json.dumps(held, indent=1, ensure_ascii=False) + "\n"


def _shares(given: Sequence[Rating], resamples: int, rng: np.random.Generator) -> Iterable[Share]:
    for question in QUESTIONS:
        for kind in KINDS:
            for view in sorted({rating.view for rating in given}):
                which = kind, question, view
                own = [r for r in given if (r.kind, r.question, r.view) == which]
                if own:
                    yield _share(own, resamples, rng)


def _share(own: Sequence[Rating], resamples: int, rng: np.random.Generator) -> Share:
    persons = {name: n for n, name in enumerate(dict.fromkeys(r.person for r in own))}
    pairs = {name: n for n, name in enumerate(dict.fromkeys(r.pair for r in own))}
    agrees = np.zeros((len(persons), len(pairs)), dtype=bool)
    answered = np.zeros_like(agrees)
    for rating in own:
        place = persons[rating.person], pairs[rating.pair]
        answered[place], agrees[place] = True, rating.answer >= AGREES
    low, high, over = interval(agrees, answered, resamples, rng)
    points = np.array([rating.answer for rating in own])
    kind, question = own[0].kind, own[0].question
    return Share(
        kind,
        question,
        own[0].view,
        len(own),
        len(persons),
        len(pairs),
        float((points >= AGREES).mean()),
        low,
        high,
        over,
        float(points.mean()),
        float((points == UNSURE).mean()),
        paper().get((kind, question)),
    )


def _drawn(n: int, resamples: int, rng: np.random.Generator) -> np.ndarray:
    """(resamples, n): how often each of n is drawn; always once where it is alone."""
    return rng.multinomial(n, np.full(n, 1 / n), size=resamples)


def _persons(everything: Sequence[Rating]) -> Iterable[Person]:
    for name in dict.fromkeys(rating.person for rating in everything):
        told = [rating for rating in everything if rating.person == name]
        unseen = {rating.pair for rating in told if rating.answer == UNSEEN}
        own = [rating for rating in told if rating.answer != UNSEEN]
        seconds: dict[str, float] = {}
        for rating in own:  # of its answers, the one given last
            seconds[rating.pair] = max(rating.seconds, seconds.get(rating.pair, 0.0))
        looked = [r for r in own if r.kind == MISMATCHED and r.question == "accurate"]
        agreed = sum(rating.answer >= AGREES for rating in looked)
        median = float(np.median(list(seconds.values()))) if seconds else None
        yield Person(name, len(seconds), median, len(looked), agreed, len(unseen))


@cache
def paper() -> Mapping[tuple[str, str], float]:
    """(kind, question) → the published share that agrees."""
    with open(resource("paper_ratings.csv"), encoding="utf-8", newline="") as file:
        return {(r["kind"], r["question"]): float(r["agree"]) for r in csv.DictReader(file)}


def _table(shares: Sequence[Share], several_views: bool) -> list[str]:
    head = ["kind", "answers", "persons", "pairs", "agree", "95 % interval", "mean", "don’t know"]
    rows = [[*head, PAPER]]
    for share in shares:
        name = f"{share.kind}, {share.view}" if several_views else share.kind
        counts = [str(n) for n in (share.answers, share.persons, share.pairs)]
        spread = "–" if share.low is None else f"{100 * share.low:.0f}–{100 * share.high:.0f} %"
        told = "–" if share.paper is None else words.percent(share.paper)
        points = [f"{share.mean:.2f}", words.percent(share.unsure)]
        rows.append([name, *counts, words.percent(share.agree), spread, *points, told])
    return table(rows)


def _persons_table(persons: Sequence[Person]) -> list[str]:
    rows = [["name", "pairs", "seconds each", "agree with mismatched"]]
    for person in persons:
        agreed = f"{person.agreed} of {person.mismatched}" if person.mismatched else "–"
        took = "–" if person.median_s is None else f"{person.median_s:.0f}"
        rows.append([person.name, str(person.pairs), took, agreed])
    return table(rows)


def _notes(found: Ratings) -> Iterable[str]:
    over = {share.over for share in found.shares}
    if "persons and pairs" in over:
        yield from wrapped("The intervals resample persons and pairs, crossed.", 0)
    if "pairs" in over:
        yield from wrapped(
            "Where one person answered, the interval resamples the pairs alone: it says nothing of "
            "what other people would answer.",
            0,
        )
    if "persons" in over:
        yield from wrapped(
            "Where there is one pair, the interval resamples the persons alone: it says nothing of "
            "other clips.",
            0,
        )
    if "exact" in over:
        yield from wrapped(
            "Where all answers are alike, the interval is the exact one of as many answers as "
            "there are pairs.",
            0,
        )
    if any(share.kind == MISMATCHED for share in found.shares):
        yield from wrapped(
            "Mismatched pairs show the timeline of another clip: who looks disagrees that they are "
            "accurate.",
            0,
        )
    else:
        yield from wrapped("No mismatched pairs: nothing tells whether people looked.", 0)
    for person in found.persons:
        if person.unseen:
            pairs = "pair" if person.unseen == 1 else "pairs"
            yield from wrapped(
                f"{person.name} had no picture of {person.unseen} {pairs}, which count nowhere.", 0
            )
        if not person.looks:
            yield from wrapped(
                f"{person.name} agrees with {person.agreed} of {person.mismatched} mismatched "
                "pairs: what they say of the others tells little.",
                0,
            )

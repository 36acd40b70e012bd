"""The page of the experiments, beside the paper's numbers."""

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.evaluation.attempts import BOUNDARIES, JOINED, REFERENCE
from mimeline.evaluation.baselines import CLASPY
from mimeline.reporting import words
from mimeline.reporting.claims import claims, verdicts
from mimeline.reporting.dots import DotChart, dot_chart
from mimeline.reporting.experiment_charts import Chart, chart
from mimeline.reporting.page import write_page
from mimeline.reporting.paired import Compared, Estimate, Key, compared

log = logging.getLogger(__name__)

NUMBERED = {"clusters": "n_clusters", "beta": "beta"}  # experiment → key of the configuration
PAPER_BEST = {
    "clusters": "In the paper: brow 9, eye 8, mouth 9, with beta 5.",
    "beta": "In the paper: 5 for all regions, of 8 clusters in its figure.",
}
ABOUT = {  # experiment → title, what it asks
    "clusters": (
        "How many clusters",
        "Too few put different motions into one cluster; too many make clusters alike (Fig. 6). "
        "Here truth names them, so that more of them cost nothing but labels.",
    ),
    "beta": (
        "The price of a switch",
        "A small beta follows the noise, a large one smooths actions away (Fig. 7). Beta counts in "
        "nats here; the paper’s 5 goes with raw channels, windows that end with their frame and "
        "costs by likelihood (docs/experiments.md).",
    ),
    "separators": (
        "Between the clips",
        "The paper joins all clips to one series, with null sequences of −1 between them, since "
        "without any the abrupt steps do harm (Fig. 7). Here windows need not reach over a border.",
    ),
    "descriptors": (
        "What describes the motion",
        "The paper finds action units less precise than blendshapes (Fig. 7: brow, 8 clusters). "
        "Its units were detected in pictures. “Action units” here are the blendshapes put through "
        "a limit, which tells what on or off loses; measured ones are the tracker’s own.",
    ),
    "sides": (
        "One side or both",
        "Faces are mostly symmetrical, so the paper uses the left side alone (3.1).",
    ),
    "unseen": (
        "Clips that were not fitted",
        "Some sources are left out, TICC is fitted and its clusters are named without them, and "
        "their clips are then annotated (4.1), beside the same clips where they were fitted too.",
    ),
    "baselines": (
        "Other methods",
        "With as many clusters or states as TICC has, each with its best name. CLaP finds their "
        "number, and is given and judged by some of the clips where there are many. Thresholds "
        "name a frame alone by the rules that propose names.",
    ),
}
SETTINGS = {"thresholds": "thresholds", "Gaussian mixture": "mixture", "Gaussian HMM": "HMM"}
HOW = {
    "CLaP": (
        "claspy cannot share an environment with mimeline. Two commands give it one of its own:",
        CLASPY,
        "snakemake --cores 2 experiments --config 'experiments={claspy: claspy/bin/python}'",
    ),
    "measured action units": (
        "They come with tracking results that hold them, as OpenFace’s and py-feat’s do "
        "(ingest.format).",
    ),
}
LIMITS = ("closure", "head", "gaze")
PREFIX, DIFFERENCE = "f1_", "difference_"


@dataclass(frozen=True)
class Cell:
    """score, difference: None where there is none; paper: what it reports, or empty."""

    score: Estimate | None
    difference: Estimate | None
    paper: str


@dataclass(frozen=True)
class Row:
    name: str
    reference: bool
    cells: list[Cell]


@dataclass(frozen=True)
class Experiment:
    name: str
    title: str
    about: str
    finding: str
    chart: Chart | None
    dots: DotChart | None
    rows: list[Row]


@dataclass(frozen=True)
class Missing:
    name: str
    reasons: list[tuple[str, list[str]]]
    how: Sequence[str]


def experiments(
    found: Mapping[str, Path],
    left_out: Mapping[str, Path],
    annotation: Path,
    paper: Path,
    page: Path,
    summary: Path,
    configured: Sequence[Mapping[str, Any]],
    side: str,
    resamples: int,
    seed: int,
    address: str,
) -> None:
    """Write the page and its numbers.

    found, left_out: tables `experiments` and `left_out` by region; annotation: `metrics` of the
    timelines as written; paper: paper_scores.csv. configured: n_clusters, beta and boundary of each
    region. summary: `metrics`, a variant "<experiment>/<setting>", metrics f1_<region> and
    difference_<region>, to the reference. address: what the log calls the page.
    """
    rows = {region: tables.read(tables.EXPERIMENTS, path) for region, path in found.items()}
    about = dict(zip(found, configured, strict=True))
    there = compared(rows, resamples, seed)
    published = pd.read_csv(paper)
    judged = [(claim, verdicts(claim, there)) for claim in claims(there, about)]
    facts = {
        "regions": list(there),
        "reasons": {r: tables.reason(p) for r, p in found.items() if r not in there},
        "settings": len({key for own in there.values() for key in own.counts}),
        "seeds": max((len(own.counts.get(REFERENCE, ())) for own in there.values()), default=0),
        "clips": max((own["clip_id"].nunique() for own in rows.values()), default=0),
        "claims": judged,
        "experiments": list(_experiments(there, about, side, published)),
        "limits": _limits(annotation, published),
        "thresholds": _written(annotation, "thresholds", there),
        "missing": _missing(left_out),
    }
    write_page(page, "experiments.html.j2", "The paper’s experiments", facts)
    table = pd.DataFrame(_summary(there, seed), columns=tables.METRICS.schema.names)
    reason = "" if len(table) else "; ".join(dict.fromkeys(facts["reasons"].values()))
    tables.write(tables.METRICS, table, summary, reason)
    log.info("the page is %s", address)


def _experiments(there, about, side, published) -> Iterator[Experiment]:
    for name, (title, text) in ABOUT.items():
        own = {r: c for r, c in there.items() if _settings(c, name) and REFERENCE in c.counts}
        if not own:
            continue
        if name in NUMBERED:
            rows = _numbered_rows(name, own, about, published)
            drawn, best = _chart(name, own, about), _best(name, own, about)
            yield Experiment(name, title, text, best, drawn, None, rows)
        else:
            rows = _rows(name, own, _base(name, own, about, side), published)
            yield Experiment(name, title, text, "", None, _dots(rows, list(own)), rows)


def _settings(own: Compared, experiment: str) -> list[str]:
    return [setting for tried, setting in own.counts if tried == experiment]


def _numbers(own: Compared, experiment: str, configured: float) -> dict[float, Key]:
    keys = {float(setting): (experiment, setting) for setting in _settings(own, experiment)}
    return {**keys, float(configured): REFERENCE}


def _best(name, own, about) -> str:
    """What does best of what was tried, beside what does in the paper."""
    said = []
    for region, scored in own.items():
        numbers = _numbers(scored, name, about[region][NUMBERED[name]])
        scores = {number: scored.score(key).value for number, key in numbers.items()}
        best = max(scores, key=scores.get)
        said.append(f"{region} {best:g} ({scores[best]:.3f})")
    return f"Best here: {', '.join(said)}. {PAPER_BEST[name]}"


def _chart(name, own, about) -> Chart | None:
    key = NUMBERED[name]
    numbers = {r: _numbers(c, name, about[r][key]) for r, c in own.items()}
    reference = {r: float(about[r][key]) for r in own}
    if name == "clusters":
        return chart("Macro-F1 over the number of clusters", "clusters", own, numbers, reference)
    beside = [
        (("null", "sequences"), ("separators", BOUNDARIES["paper"])),
        (("clips apart",), ("separators", BOUNDARIES["mask"])),
        (("no separator",), ("separators", JOINED)),
        (("action units", "by rule"), ("descriptors", "action units")),
    ]
    x_title = "beta, nats (logarithmic)"
    return chart("Macro-F1 over beta", x_title, own, numbers, reference, beside, logarithmic=True)


def _numbered_rows(name, own, about, published) -> list[Row]:
    numbers = {r: _numbers(c, name, about[r][NUMBERED[name]]) for r, c in own.items()}
    rows = []
    for number in sorted({number for keys in numbers.values() for number in keys}):
        cells = [
            _cell(own[r], keys[number], r, published) if number in keys else Cell(None, None, "")
            for r, keys in numbers.items()
        ]
        here = all(keys.get(number) == REFERENCE for keys in numbers.values())
        rows.append(Row(f"{number:g}", here, cells))
    return rows


def _rows(name, own, base: str, published) -> list[Row]:
    settings = list(dict.fromkeys(s for c in own.values() for s in _settings(c, name)))
    like = ("unseen", "unseen") if name == "unseen" else None
    first = [Cell(c.score(REFERENCE, like), None, _paper(published, REFERENCE, r))
             for r, c in own.items()]  # fmt: skip
    rows = [Row(base, True, first)]
    for setting in settings:
        key = (name, setting)
        cells = [
            _cell(c, key, r, published) if key in c.counts else Cell(None, None, "")
            for r, c in own.items()
        ]
        rows.append(Row(setting, False, cells))
    return rows


def _cell(own: Compared, key: Key, region: str, published: pd.DataFrame) -> Cell:
    difference = None if key == REFERENCE else own.difference(key, REFERENCE)
    return Cell(own.score(key), difference, _paper(published, key, region))


def _base(name: str, own, about, side: str) -> str:
    """What the configured setting is called among those of an experiment."""
    boundaries = [BOUNDARIES[about[region]["boundary"]] for region in own]
    return {
        "separators": " or ".join(dict.fromkeys(boundaries)),
        "descriptors": "blendshapes",
        "sides": f"{side} side",
        "unseen": "fitted as well",
        "baselines": "TICC",
    }[name]


def _paper(published: pd.DataFrame, key: Key, region: str) -> str:
    asked = ("reference", "optimum") if key == REFERENCE else key
    own = published[
        (published["experiment"] == asked[0])
        & (published["setting"] == asked[1])
        & (published["region"] == region)
    ]
    if own.empty:
        return ""
    best = "’s best" if key == REFERENCE else ""
    return f"paper{best} {words.score(own['value'].iloc[0])}"


def _dots(rows: Sequence[Row], regions: Sequence[str]) -> DotChart | None:
    names = {f"{n}": SETTINGS.get(row.name, row.name) for n, row in enumerate(rows)}
    drawn = [
        (f"{n}", region, cell.score.value, cell.score.low, cell.score.high)
        for n, row in enumerate(rows)
        for region, cell in zip(regions, row.cells, strict=True)
        if cell.score
    ]
    columns = ["metric", "variant", "value", "low", "high"]
    return dot_chart(pd.DataFrame(drawn, columns=columns), "", names, regions)


def _limits(annotation: Path, published: pd.DataFrame) -> list[tuple[str, Any, str]]:
    """(region, its row of the metrics, what the paper reports) of what limits alone annotate."""
    rows = tables.read(tables.METRICS, annotation)
    own = rows[rows["variant"] == "named"].set_index("metric")
    return [
        (region, own.loc[PREFIX + region], _paper(published, ("thresholds", "thresholds"), region))
        for region in LIMITS
        if PREFIX + region in own.index
    ]


def _written(annotation: Path, variant: str, regions) -> dict[str, float]:
    """Macro-F1 of a variant of the timelines as annotate would write them."""
    rows = tables.read(tables.METRICS, annotation)
    own = rows[rows["variant"] == variant].set_index("metric")["value"]
    return {region: own[PREFIX + region] for region in regions if PREFIX + region in own}


def _missing(left_out: Mapping[str, Path]) -> list[Missing]:
    rows = pd.concat([tables.read(tables.LEFT_OUT, path) for path in left_out.values()])
    found = []
    for (experiment, setting), own in rows.groupby(["experiment", "setting"], sort=False):
        reasons = [(reason, list(each["region"])) for reason, each in own.groupby("reason")]
        title = ABOUT[experiment][0] if experiment in ABOUT else "As configured"
        found.append(Missing(f"{title}: {setting}", reasons, HOW.get(setting, ())))
    return found


def _summary(there: Mapping[str, Compared], seed: int) -> Iterator[tuple]:
    for region, own in there.items():
        for key in own.counts:
            variant, n = "/".join(key), own.frames(key)
            yield _line(variant, PREFIX + region, own.score(key), n, seed)
            if key != REFERENCE and REFERENCE in own.counts:
                gain = own.difference(key, REFERENCE)
                yield _line(variant, DIFFERENCE + region, gain, n, seed)


def _line(variant: str, metric: str, said: Estimate, n: int, seed: int) -> tuple:
    value, low, high = (float(np.float64(v)) for v in (said.value, said.low, said.high))
    return ("experiments", variant, "all", metric, value, low, high, n, seed)

"""The page of a sweep: which number of clusters and which price of a switch each score favours."""

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.reporting import words
from mimeline.reporting.page import write_page
from mimeline.reporting.panels import Grid, Panel, Point, favourite, grid, panels

log = logging.getLogger(__name__)

ALIKE = 0.01  # macro-F1 that makes no difference in practice
LEAST = {"n_clusters": 1, "beta": 0}  # beyond which no grid can reach
STABLE = 0.9  # adjusted Rand index from which starts agree
SCORES = {  # column → name, and what is said of it
    "f1": ("macro-F1", "how right the best names for these clusters are; higher is better"),
    "bic": ("BIC above its lowest", "needs no truth; lower is better"),
    "stability": ("stability", "how much different starts agree; higher is better"),
}
CHOOSERS = {"f1": "macro-F1 against the truth", "bic": "BIC, which needs no truth"}


@dataclass(frozen=True)
class Region:
    """What a region's part of the page shows; reason: why it shows nothing."""

    name: str
    reason: str
    findings: list[str]
    grids: list[Grid]


def sweep(
    page: Path,
    scores: Mapping[str, Path],
    n_clusters: Sequence[int],
    beta: Sequence[float],
    address: str,
) -> None:
    """Write the page. scores: `sweep` tables by region; n_clusters, beta: as configured for each.

    address: what the log calls the page.
    """
    points, regions, fits = {}, [], 0
    configured = dict(zip(scores, map(Point, n_clusters, beta), strict=True))
    for region, path in scores.items():
        rows = tables.read(tables.SWEEP, path)
        fits += len(rows)
        if rows.empty:
            regions.append(Region(region, tables.reason(path), [], []))
            continue
        own = points[region] = summary(rows)
        most, said = int(own["n_clusters"].max()), []
        if (asked := configured[region]).n_clusters > most:
            configured[region] = asked._replace(n_clusters=most)
            text = f"The frames are too few for {asked.n_clusters} clusters, as configured"
            said.append(f"{text}: {most} stand for it here.")
        known = [name for name in SCORES if own[name].notna().any()]
        grids = [grid(own, name, SCORES[name][0], configured[region]) for name in known]
        regions.append(Region(region, "", said + findings(own, configured[region]), grids))
    known = [name for name in SCORES if any(own[name].notna().any() for own in points.values())]
    drawn: list[list[Panel]] = [panels(points, name, SCORES[name][0], configured) for name in known]
    choices = {
        about: {r: favourite(own, name) for r, own in points.items() if own[name].notna().any()}
        for name, about in CHOOSERS.items()
        if name in known
    }
    facts = {
        "fits": fits,
        "seeds": max((int(own["seeds"].max()) for own in points.values()), default=0),
        "scores": {name: SCORES[name] for name in known},
        "panels": drawn,
        "regions": regions,
        "choices": [(about, _block(own), _command(own)) for about, own in choices.items()],
    }
    write_page(page, "sweep.html.j2", "Which clusters, which beta?", facts)
    for about, own in choices.items():
        log.info("by %s: segment: %s", about, _flow(own))
    log.info("the page is %s", address)


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """A region's `sweep` table, a row per n_clusters and beta: means over the seeds.

    f1 and bic come with their extremes (f1_low, f1_high, ...). bic is what it lies above the lowest
    of these means.
    """
    rows = rows.assign(f1=rows["f1"].astype("float64"))
    points = rows.groupby(["n_clusters", "beta"], as_index=False).agg(
        seeds=("seed", "size"),
        f1=("f1", "mean"),
        f1_low=("f1", "min"),
        f1_high=("f1", "max"),
        bic=("bic", "mean"),
        bic_low=("bic", "min"),
        bic_high=("bic", "max"),
        stability=("stability", "mean"),
        mean_frames=("mean_frames", "mean"),
    )
    points[["bic_low", "bic_high", "bic"]] -= points["bic"].min()
    return points.assign(stability_low=points["stability"], stability_high=points["stability"])


def findings(points: pd.DataFrame, configured: Point) -> list[str]:
    """What the scores say of a region, in sentences. configured: one of the points."""
    at = points.set_index(["n_clusters", "beta"])
    now, found = at.loc[configured], []
    truth = points["f1"].notna().any()
    if truth:
        found += [_against_truth(points, configured, now), _plateau(points, configured)]
    best = favourite(points, "bic")
    text = f"BIC favours {best}"
    found.append(f"{text}, where macro-F1 is {at.loc[best, 'f1']:.3f}." if truth else f"{text}.")
    edges = [
        name
        for name, value in best._asdict().items()
        if value > LEAST[name] and points[name].nunique() > 1 and value in _ends(points[name])
    ]
    if edges:
        keys = words.listing([f"sweep.{name}" for name in edges])
        found.append(f"That is the edge of the grid: it may lie beyond {keys}.")
    if points["stability"].notna().any():
        there, here = _agree(at.loc[best, "stability"]), _agree(now["stability"])
        found.append(f"Different starts {there} there; as configured they {here}.")
    found.append(
        f"An interval lasts {at.loc[best, 'mean_frames']:.0f} frames on average where BIC is best, "
        f"{now['mean_frames']:.0f} as configured."
    )
    return found


def _against_truth(points: pd.DataFrame, configured: Point, now: pd.Series) -> str:
    best = favourite(points, "f1")
    top = f"{points.set_index(['n_clusters', 'beta']).loc[best, 'f1']:.3f}"
    text = f"Against the truth, {best} do best: macro-F1 {top}"
    if best == configured:
        return f"{text}, as configured."
    if top == f"{now['f1']:.3f}":
        return f"{text}; the configured {configured} do as well."
    return f"{text}; as configured, {configured}, it is {now['f1']:.3f}."


def _plateau(points: pd.DataFrame, configured: Point) -> str:
    """The values of each that lose nothing that matters, the other as configured."""
    good = points[points["f1"] >= points["f1"].max() - ALIKE]
    counts = good.loc[good["beta"] == configured.beta, "n_clusters"]
    betas = good.loc[good["n_clusters"] == configured.n_clusters, "beta"]
    return (
        f"Within {ALIKE:g} of the best: {_values(counts)} clusters at beta {configured.beta:g}; "
        f"beta {_values(betas)} at {configured.n_clusters} clusters."
    )


def _ends(values: pd.Series) -> tuple[float, float]:
    return values.min(), values.max()


def _values(values: pd.Series) -> str:
    return words.listing([f"{value:g}" for value in sorted(values)]) or "none"


def _agree(stability: float) -> str:
    word = "agree" if stability >= STABLE else "disagree"
    return f"{word} ({stability:.2f})"


def _entries(choice: Mapping[str, Point]) -> Iterator[str]:
    for region, point in choice.items():
        yield f"{region}: {{n_clusters: {point.n_clusters}, beta: {point.beta:g}}}"


def _flow(choice: Mapping[str, Point]) -> str:
    """The choice as a config value on one line."""
    return "{" + ", ".join(_entries(choice)) + "}"


def _block(choice: Mapping[str, Point]) -> str:
    """The choice as lines of the config file."""
    return "\n  ".join(["segment:", *_entries(choice)])


def _command(choice: Mapping[str, Point]) -> str:
    return f"snakemake --cores 2 all --config 'segment={_flow(choice)}'"

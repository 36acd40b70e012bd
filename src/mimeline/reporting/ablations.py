"""The page of the ablation study, beside the paper's Table 2."""

import logging
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.evaluation.ablations import Asked, channels_of, of_recordings, scored
from mimeline.evaluation.coupling import pulls
from mimeline.evaluation.unseen import choose
from mimeline.evaluation.variants import (
    ASKED,
    CONFLICT,
    MADE,
    NARROW,
    OURS,
    UNSEEN,
    WIDE,
    Variant,
    variants,
)
from mimeline.reporting.ablation_claims import judged
from mimeline.reporting.ablation_pictures import Cloud, Panel, clouds, panel, telling
from mimeline.reporting.ablation_scores import Study
from mimeline.reporting.dots import DotChart, dot_chart
from mimeline.reporting.page import write_page
from mimeline.reporting.paired import Estimate
from mimeline.reporting.published import published

log = logging.getLogger(__name__)

REAL = "real"
METRICS = {  # → what the table calls it, decimals
    "tas": ("TAS ↑", 3),
    "conflict": ("TAS ↑, conflicts", 3),
    "drift": ("head drift", 3),
    "var": ("Var →", 4),
    "fid_fm": ("FID ↓", 3),
    "fid_delta_fm": ("FIDΔ ↓", 4),
    "snd": ("SND ↓", 3),
}
DRAWN = {"tas": UNSEEN, "conflict": CONFLICT}  # metric of the dot chart → its class
APART = "difference_"


@dataclass(frozen=True)
class Cell:
    """said: of a variant, None where it has no such score; difference: to ours."""

    said: Estimate | None
    difference: Estimate | None
    paper: float | None
    decimals: int


@dataclass(frozen=True)
class Row:
    """keys: of train.timeline that differ from the configured, with their values."""

    title: str
    keys: list[str]
    ours: bool
    cells: list[Cell]


def ablations(
    asked: Mapping[str, Path],
    made: Mapping[tuple[str, int, str], Path],
    found: Mapping[tuple[str, int, str], Path],
    motions: Sequence[str | Path],
    frames: Sequence[str | Path],
    clips: Sequence[str | Path],
    split: str | Path,
    paper: str | Path,
    page: Path,
    summary: Path,
    configured: Mapping[str, Any],
    wanted: Collection[str],
    side: str,
    unseen: int,
    choice_seed: int,
    resamples: int,
    seed: int,
    address: str,
) -> None:
    """Write the page and its numbers, and tell the table in the log.

    asked: `frames` by set of ASKED. made, found: `motion` by variant, seed and set of MADE, and the
    `frames` found in it, of ASKED. motions, frames, clips, split: of the recordings. paper:
    paper_ablations.csv. configured, wanted: keys of train.timeline and ablations.variants. unseen,
    choice_seed: as for the set of that name. summary: `metrics`, a metric and its
    difference_<metric> to ours, of each variant. address: what the log calls the page.
    """
    motion, marked = tables.read_all(tables.MOTION, motions), tables.read_all(tables.FRAMES, frames)
    rows = variants(configured, wanted)
    seeds = sorted({seed for _, seed, _ in made})
    runs = Runs(made, found)
    rng = np.random.default_rng(choice_seed)
    part, _, others = choose(tables.read(tables.SPLIT, split), marked, unseen, rng)
    told = {name: tables.read(tables.FRAMES, path) for name, path in asked.items()}
    known = Asked.of(told, motion, resamples, seed)
    channels = channels_of(runs.motion(OURS, seeds[0], UNSEEN))
    real, counts = of_recordings(known, motion, marked, others, channels, seed)
    draws = {REAL: {0: real}}
    for name in rows:
        draws[name] = {own: runs.scored(name, own, known) for own in seeds}
    study = Study(draws)
    values = published(paper)
    metrics = {m: about for m, about in METRICS.items() if study.score(OURS, m)}
    first = seeds[0]
    fps = _rate(tables.read_all(tables.CLIPS, clips, ["fps_num", "fps_den"]))
    facts = {
        "part": part,
        "seeds": len(seeds),
        "timelines": {name: len(own) for name, own in known.clips.items()},
        "reasons": _reasons(runs, asked, first, metrics),
        "metrics": [title for title, _ in metrics.values()],
        "claims": judged(study, rows, configured["branch_layers"], values),
        "rows": list(_rows(study, rows, metrics, values, configured)),
        "real": [_cell(study, REAL, m, values.get((REAL, m))) for m in metrics],
        "titles": {m: title.strip("↑↓→ ") for m, (title, _) in METRICS.items()},
        "dots_chart": _dots(study, rows, metrics),
        "panels": _panels(runs, rows, told[CONFLICT], first, side, fps),
        "clouds": _clouds(runs, rows, known, study, first),
    }
    write_page(page, "ablations.html.j2", "The ablation study", facts)
    table = pd.DataFrame(
        _summary(study, rows, part, known, counts, seeds), columns=tables.METRICS.schema.names
    )
    reason = "" if len(table) else "; ".join(facts["reasons"])
    tables.write(tables.METRICS, table, summary, reason)
    for line in _lines(study, rows, metrics):
        log.info("%s", line)
    log.info("the page is %s", address)


@dataclass(frozen=True)
class Runs:
    """made, found: what variants made and what is found in it, files by variant, seed and set."""

    made: Mapping[tuple[str, int, str], Path]
    found: Mapping[tuple[str, int, str], Path]

    def motion(self, variant: str, seed: int, asked: str) -> pd.DataFrame:
        return tables.read(tables.MOTION, self.made[variant, seed, asked])

    def frames(self, variant: str, seed: int, asked: str) -> pd.DataFrame:
        return tables.read(tables.FRAMES, self.found[variant, seed, asked])

    def scored(self, variant: str, seed: int, asked: Asked) -> dict[str, np.ndarray]:
        """The draws of each score of a training."""
        return scored(
            asked,
            {name: self.motion(variant, seed, name) for name in MADE},
            {name: self.frames(variant, seed, name) for name in ASKED},
        )


def _rows(study, rows, metrics, values, configured) -> Iterator[Row]:
    for name, variant in rows.items():
        cells = [_cell(study, name, m, values.get((variant.paper, m))) for m in metrics]
        keys = [f"{key}: {value}" for key, value in variant.changes.items()]
        own = keys or [f"{key}: {configured[key]}" for key in ("base_layers", "branch_layers")]
        yield Row(variant.title, own, name == OURS, cells)


def _cell(study: Study, variant: str, metric: str, paper: float | None) -> Cell:
    apart = study.apart(variant, metric) if variant != REAL else None
    return Cell(study.score(variant, metric), apart, paper, METRICS[metric][1])


def _reasons(runs: Runs, asked, seed: int, metrics) -> list[str]:
    """Why there are no scores, or not all."""
    found = []
    for name, about in ((UNSEEN, "No score"), (CONFLICT, "No conflicts")):
        if why := tables.reason(asked[name]) or tables.reason(runs.made[OURS, seed, name]):
            found.append(f"{about}: {why}")
    if not found and "drift" not in metrics:
        found.append("No drift: no gaze is held long enough, or none has a head beside it")
    return found


def _dots(study: Study, rows: Mapping[str, Variant], metrics) -> DotChart | None:
    drawn = [
        (name, kind, said.value, said.low, said.high)
        for name in rows
        for metric, kind in DRAWN.items()
        if (said := study.score(name, metric))
    ]
    columns = ["metric", "variant", "value", "low", "high"]
    names = {name: variant.title for name, variant in rows.items()}
    return dot_chart(pd.DataFrame(drawn, columns=columns), "", names, list(DRAWN.values()))


def _panels(runs: Runs, rows, asked: pd.DataFrame, seed: int, side: str, fps: float) -> list[Panel]:
    """Ours and the variant without branches on one conflicting timeline."""
    if "no-branch" not in rows or asked.empty:
        return []
    both = {name: runs.motion(name, seed, CONFLICT) for name in (OURS, "no-branch")}
    if any(made.empty for made in both.values()):
        return []
    clip = telling(asked, *(runs.frames(name, seed, CONFLICT) for name in both))
    return [
        panel(rows[name].title, _of(asked, clip), _of(made, clip), side, fps)
        for name, made in both.items()
    ]


def _clouds(runs: Runs, rows, known: Asked, study: Study, seed: int) -> list[Cloud]:
    """Ours and the variant without a base."""
    if "no-base" not in rows or study.score(OURS, "drift") is None:
        return []
    farther, slopes = {}, {}
    for name in (OURS, "no-base"):
        made = [runs.motion(name, seed, eyes) for eyes in (NARROW, WIDE)]
        farther[rows[name].title] = pulls(known.frames[UNSEEN], *made)
        slopes[rows[name].title] = study.score(name, "drift")
    return clouds(farther, slopes)


def _of(table: pd.DataFrame, clip: str) -> pd.DataFrame:
    return table[table["clip_id"] == clip].reset_index(drop=True)


def _rate(clips: pd.DataFrame) -> float:
    """Frames per second of the recordings, of the first that tells; else 30."""
    known = clips.dropna()
    return float(Fraction(*map(int, known.iloc[0]))) if len(known) else 30.0


def _summary(study: Study, rows, part: str, known: Asked, real, seeds) -> Iterator[tuple]:
    """real: of how many clips each score of the recordings is."""
    sets = {"conflict": CONFLICT, "conflict_tas": CONFLICT}
    for name in (*rows, REAL):
        for metric in next(iter(study.draws[name].values())):
            n = real[metric] if name == REAL else len(known.clips[sets.get(metric, UNSEEN)])
            yield _line(name, part, metric, study.score(name, metric), n, seeds)
            if name not in (OURS, REAL) and (apart := study.apart(name, metric)):
                yield _line(name, part, APART + metric, apart, n, seeds)


def _line(variant: str, part: str, metric: str, said: Estimate, n: int, seeds) -> tuple:
    return ("ablations", variant, part, metric, said.value, said.low, said.high, n, seeds[0])


def _lines(study: Study, rows: Mapping[str, Variant], metrics) -> Iterator[str]:
    """The table in text: values, the difference to ours in brackets."""
    titles = [f"{title:>19}" for title, _ in metrics.values()]
    yield f"{'':<14}{''.join(titles)}"
    for name, variant in {**rows, REAL: Variant(REAL, "real clips")}.items():
        cells = []
        for metric, (_, decimals) in metrics.items():
            said, apart = study.score(name, metric), None
            if name != REAL:
                apart = study.apart(name, metric)
            text = f"{said.value:.{decimals}f}" if said else "–"
            cells.append(text + (f" ({apart.value:+.{decimals}f})" if apart else ""))
        yield f"{variant.title:<14}" + "".join(f"{cell:>19}" for cell in cells)

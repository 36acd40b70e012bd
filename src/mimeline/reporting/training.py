"""How a model learned, and how well it follows a timeline."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.progress import duration
from mimeline.reporting import words
from mimeline.reporting.dots import DotChart, dot_chart
from mimeline.reporting.drawing import Scale, curve, ticks
from mimeline.reporting.motion_scores import REAL, MotionTable, motion_table
from mimeline.reporting.published import published

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 720, 250, 56, 92, 12, 34
PREFIX = "tas_"
REGIONS = {
    "": "all regions",
    "brow": "brow",
    "eye": "eye (lid)",
    "closure": "closure",
    "mouth": "mouth",
    "gaze": "gaze",
    "head": "head",
}
VARIANTS = ("request", "empty", "unconditional")
PAPER_TIMELINES = 100  # Ma et al. 2025, 4.2


@dataclass(frozen=True)
class Line:
    """A curve with its name at its end."""

    kind: str
    name: str
    path: str
    x: float
    y: float


@dataclass(frozen=True)
class Curve:
    lines: list[Line]
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    width: float
    height: float
    floor: float
    left: float
    right: float
    logarithmic: bool


@dataclass(frozen=True)
class Model:
    """What the page says about a model.

    reason: why there is none; metrics_reason: why it has no scores. tas: by variant; published:
    the paper's. seen: whether clips of the training are among those asked for; few: whether they
    are fewer than the paper's.
    """

    name: str
    reason: str
    metrics_reason: str
    curve: Curve | None
    facts: list[str]
    chart: DotChart | None
    tas: dict[str, float]
    published: float
    part: str
    seen: bool
    few: bool
    table: MotionTable | None


def model(name: str, checkpoint: str | Path, metrics: str | Path) -> Model:
    """checkpoint: a folder with log.parquet (`losses`); metrics: the model's `metrics` table."""
    log = Path(checkpoint) / "log.parquet"
    losses = tables.read(tables.LOSSES, log)
    reason = (tables.reason(log) or "no step of training was done") if losses.empty else ""
    rows = tables.read(tables.METRICS, metrics)
    why = (tables.reason(metrics) or "nothing was scored") if rows.empty else ""
    tas = rows[rows["metric"] == "tas"].set_index("variant")["value"].dropna().to_dict()
    aligned = rows.assign(metric=rows["metric"].replace("tas", PREFIX))
    variants = [v for v in (*VARIANTS, REAL) if v in set(rows["variant"])]
    return Model(
        name=name,
        reason=reason,
        metrics_reason=why,
        curve=None if losses.empty else loss_curve(losses),
        facts=_facts(losses),
        chart=dot_chart(aligned, PREFIX, REGIONS, VARIANTS),
        tas={variant: float(value) for variant, value in tas.items()},
        published=published()["Ours", "tas"],
        part=_part(rows),
        seen="train" in "+".join(rows["part"].unique()).split("+"),
        few=bool((rows["n"] < PAPER_TIMELINES).any()),
        table=motion_table(rows, variants),
    )


def _part(rows: pd.DataFrame) -> str:
    names = {"train": "training", "val": "validation", "test": "test"}
    if rows.empty:
        return ""
    parts = [names.get(part, part) for part in str(rows["part"].iloc[0]).split("+")]
    return (
        words.clips(int(rows.loc[rows["variant"] != REAL, "n"].max()))
        + f" of the {words.listing(parts)} part{'s' if len(parts) > 1 else ''}"
    )


def _facts(losses: pd.DataFrame) -> list[str]:
    if losses.empty:
        return []
    last = losses.iloc[-1]
    facts = [f"{words.count(last['step'])} steps in {duration(last['seconds'])}"]
    checked = losses.dropna(subset=["val_loss"])
    if len(checked):
        best = checked.loc[checked["val_loss"].idxmin()]
        facts.append(
            f"lowest validation loss {words.number(best['val_loss'])} at step "
            f"{words.count(best['step'])}"
        )
    facts.append(f"last training loss {words.number(last['loss'])}")
    return facts


def loss_curve(losses: pd.DataFrame) -> Curve:
    """The `losses` as a picture; logarithmic where they span more than a factor of eight."""
    shown = losses[["loss", "val_loss"]].to_numpy("float64")
    finite = shown[np.isfinite(shown)]
    logarithmic = bool(len(finite) and finite.min() > 0 and finite.max() / finite.min() > 8)
    view = np.log10 if logarithmic else np.asarray
    low = float(view(finite.min())) if logarithmic else 0.0
    high = float(view(finite.max())) if len(finite) else 1.0
    pad = 0.04 * (high - low or 1.0)
    x = Scale(0, float(losses["step"].max()), LEFT, WIDTH - RIGHT)
    y = Scale(low - (pad if logarithmic else 0), high + pad, HEIGHT - FOOT, TOP)
    lines = []
    for kind, column, name in (("loss", "loss", "training"), ("val", "val_loss", "validation")):
        own = losses.dropna(subset=[column])
        if own.empty:
            continue
        values = view(own[column].to_numpy("float64"))
        path = curve(own["step"], values, x, y)
        lines.append(Line(kind, name, path, x(own["step"].iloc[-1]), y(float(values[-1]))))
    return Curve(
        _apart(lines),
        [(x(t), words.count(t)) for t in ticks(0, float(losses["step"].max()), 6)],
        _decades(low, high, y) if logarithmic else [(y(t), f"{t:g}") for t in ticks(0, high, 4)],
        WIDTH,
        HEIGHT,
        HEIGHT - FOOT,
        LEFT,
        WIDTH - RIGHT,
        logarithmic,
    )


def _decades(low: float, high: float, y: Scale) -> list[tuple[float, str]]:
    powers = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    steps = [m * 10.0**power for power in powers for m in (1, 2, 5)]
    return [(y(float(np.log10(s))), f"{s:g}") for s in steps if low <= np.log10(s) <= high]


def _apart(lines: list[Line], least: float = 14.0) -> list[Line]:
    """The names at the curves' ends, moved apart."""
    if len(lines) < 2 or abs(lines[0].y - lines[1].y) >= least:
        return lines
    middle = (lines[0].y + lines[1].y) / 2
    up = 0 if lines[0].y <= lines[1].y else 1
    ys = {up: middle - least / 2, 1 - up: middle + least / 2}
    return [
        Line(line.kind, line.name, line.path, line.x, round(ys[i], 1))
        for i, line in enumerate(lines)
    ]

"""A small run, made by hand: three clips in two shards, one of them dropped, one failed."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.media.film import write_film
from mimeline.reporting.report import report
from mimeline.vocabulary import ACTIONS, CHANNELS, SERIES_REGIONS, series_channels

FRAMES, FPS, EDGE = 60, 30, 64
MADE = 10  # frames that the model made: each is drawn twice
KEPT = "kept_1"
OPTIONS = {"title": "A small run", "clips": 2, "exemplars": 3}
SOURCES = {
    "folder": "videos",
    "max_pixels": 10_000_000,
    "max_source_s": 600.0,
    "max_mb": 100.0,
    "timeout_s": 60.0,
}
LIMITS = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 8.0, "hysteresis": 0.0, "min_frames": 1}


def _ledger(path: Path, stage: str, rows: list[dict]) -> Path:
    """A ledger of one stage; rows need clip_id and status."""
    blank = dict.fromkeys(tables.LEDGER.schema.names) | {"stage": stage}
    columns = tables.LEDGER.schema.names
    table = pd.DataFrame([blank | row for row in rows], columns=columns)
    tables.write(tables.LEDGER, table, path)
    return path


def clips(path: Path, ids: list[str], media: dict[str, Path] | None = None) -> Path:
    blank = dict.fromkeys(tables.CLIPS.schema.names)
    rows = [
        blank
        | {
            "clip_id": clip,
            "source_id": f"video of {clip}",
            "start_s": 0.0,
            "end_s": FRAMES / FPS,
            "fps_num": FPS,
            "fps_den": 1,
            "n_frames": FRAMES,
            "actions": [{"name": "smile", "start_s": 0.0, "end_s": 1.0, "uncertainty_s": 1.0}],
            "emotions": [],
            "attributes": ["young", "lighting:soft_light"],
            "texts": [],
            "shard": 0,
            "media": str(media[clip]) if media and clip in media else None,
        }
        for clip in ids
    ]
    tables.write(tables.CLIPS, pd.DataFrame(rows, columns=tables.CLIPS.schema.names), path)
    return path


def motion(ids: list[str]) -> pd.DataFrame:
    wave = 0.3 + 0.3 * np.sin(np.arange(FRAMES) / 9)
    parts = [
        pd.DataFrame(
            {"clip_id": clip, "frame": np.arange(FRAMES), "valid": True}
            | {"confidence": np.nan, "tracker_loss": np.nan}
            | dict.fromkeys(CHANNELS, wave)
        )
        for clip in ids
    ]
    return pd.concat(parts) if parts else tables.empty(tables.MOTION)


def frames(ids: list[str], unmeasured: tuple[str, ...] = ()) -> pd.DataFrame:
    """Every action of the first half of the frames that is the first of its track."""
    active = np.arange(FRAMES) < FRAMES // 2
    marks = {
        action: active if action in ("BrowUp", "Smile", "GazeLeft", "HeadUp") else False
        for action in ACTIONS
    } | dict.fromkeys(unmeasured, pd.NA)
    parts = [
        pd.DataFrame({"clip_id": clip, "frame": np.arange(FRAMES)} | marks).astype(
            dict.fromkeys(ACTIONS, "boolean")
        )
        for clip in ids
    ]
    return pd.concat(parts) if parts else tables.empty(tables.FRAMES)


def looked(looks: int = 10, needed: int = 4) -> list[dict]:
    """Rows of the labelling's metrics: as good as it gets after `needed` looks, chosen well."""

    def row(variant: str, metric: str, n: int, value: float, spread: float | None = None) -> dict:
        known = {"model": "labelling", "part": "all", "seed": 0}
        own = {"variant": variant, "metric": metric, "n": n, "value": value}
        ends = {} if spread is None else {"low": value - spread, "high": min(value + spread, 1)}
        return known | own | ends

    rows = []
    for metric in ("f1", "f1_brow", "f1_eye", "f1_mouth"):
        for n in range(looks + 1):
            rows.append(row("active", metric, n, 0.9 if n else 0.85))
            rows.append(row("active_unproposed", metric, n, 0.9 * min(n / needed, 1)))
            rows.append(row("random_unproposed", metric, n, 0.9 * n / looks, 0.05))
        rows.append(row("proposed", metric, 0, 0.85))
        rows.append(row("person", metric, looks, 0.9))
        rows.append(row("oracle", metric, looks, 0.93))
    return rows


def _write(table: tables.Table, rows: list[dict], path: Path, reason: str = "") -> Path:
    blank = dict.fromkeys(table.schema.names)
    filled = pd.DataFrame([blank | row for row in rows], columns=table.schema.names)
    tables.write(table, filled, path, "" if rows else reason)
    return path


@pytest.fixture
def ledger() -> Callable[..., Path]:
    """Writes a stage's ledger: path, stage, rows of clip_id, status and more; gives the path."""
    return _ledger


def filmed(number: int, red: int = 0) -> np.ndarray:
    """Frame `number` of a film whose green tells the number."""
    return np.full((EDGE, EDGE, 3), (red, 20 + 3 * number, 90), np.uint8)


@pytest.fixture(scope="session")
def video(tmp_path_factory) -> Path:
    """A short film, as long as the clips of the run."""
    path = tmp_path_factory.mktemp("video") / "clip.mp4"
    write_film(path, (filmed(number) for number in range(FRAMES)), Fraction(FPS))
    return path


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., dict]:
    """Writes a run's tables and gives the arguments of `report`.

    clip: the id of the clip that is kept; note: of a cluster. unmeasured: actions without channels;
    media: clip → video.
    """

    def make(
        clip: str = KEPT,
        note: str = "strong",
        unmeasured: tuple[str, ...] = (),
        media: dict[str, Path] | None = None,
    ) -> dict:
        return _full(tmp_path, clip, note, unmeasured, media)

    return make


@pytest.fixture(scope="session")
def plain_page(tmp_path_factory) -> str:
    """The page of a run without videos."""
    return written(_full(tmp_path_factory.mktemp("plain"), KEPT, "strong", (), None))


@pytest.fixture(scope="session")
def filmed_page(tmp_path_factory, video: Path) -> str:
    """The page of a run whose kept and whose failed clip have a video."""
    media = {KEPT: video, "bad": video}
    return written(_full(tmp_path_factory.mktemp("filmed"), KEPT, "strong", (), media))


def written(arguments: dict) -> str:
    report(**arguments)
    return arguments["page"].read_text(encoding="utf-8")


def _full(
    at: Path,
    clip: str,
    note: str,
    unmeasured: tuple[str, ...],
    media: dict[str, Path] | None,
) -> dict:
    short = {"rule": "too_short", "value": 3.4, "limit": 5.0, "unit": "s"}
    unread = {"rule": "unreadable", "detail": "line 812: found n/a", "first_frame": 3}
    skipped = {"rule": "turned", "detail": "not applied: no head angle is known for this clip"}
    kept = {"clip_id": clip, "status": "kept"}
    ledgers = [
        _ledger(
            at / "catalogue.parquet",
            "catalogue",
            [kept, {"clip_id": "short_1", "status": "kept"}, {"clip_id": "bad", "status": "kept"}],
        ),
        _ledger(
            at / "select" / "00" / "ledger.parquet",
            "select",
            [kept, {"clip_id": "short_1", "status": "dropped"} | short],
        ),
        _ledger(
            at / "select" / "01" / "ledger.parquet",
            "select",
            [{"clip_id": "bad", "status": "kept"}],
        ),
        _ledger(
            at / "fetch.parquet",
            "fetch",
            [kept | {"rule": "no_video"}, {"clip_id": "bad", "status": "kept"}],
        ),
        _ledger(
            at / "ingest.parquet",
            "ingest",
            [kept, {"clip_id": "bad", "status": "failed"} | unread],
        ),
        _ledger(at / "pose.parquet", "pose", [kept | skipped]),
        _ledger(at / "split.parquet", "split", [kept]),
    ]
    moving, marked = motion([clip]), frames([clip], unmeasured)
    paths = {name: at / f"{name}.parquet" for name in ("motion", "frames", "generated")}
    tables.write(tables.MOTION, moving, paths["motion"])
    tables.write(tables.MOTION, moving.head(MADE), paths["generated"])
    tables.write(tables.FRAMES, marked, paths["frames"])
    truth = at / "truth"
    tables.write(tables.FRAMES, frames([clip]), truth / "frames.parquet")
    (truth / "faults.csv").write_text(
        "clip_id,fault,stage,status\nshort_1,too_short,select,dropped\nbad,lost,pose,dropped\n"
    )
    interval = {"clip_id": clip, "start_frame": 0, "end_frame": 30}
    found = [interval | {"track": "brow", "action": "BrowUp", "source": "ticc", "cluster": 1}]
    found.append(interval | {"track": "mouth", "action": "Smile", "source": "ticc", "cluster": 1})
    series, clusters = {}, {}
    for region in SERIES_REGIONS:
        channels = list(series_channels(region, "left"))
        long = moving[["clip_id", "frame", *channels]].assign(position=np.arange(FRAMES))
        series[region] = at / f"{region}.parquet"
        tables.write(tables.SERIES[region, "left"], long, series[region])
        clusters[region] = at / f"{region}_clusters.parquet"
        assigned = {"cluster": (np.arange(FRAMES) < 30).astype(int), "margin": 1.0}
        own = moving[["clip_id", "frame"]].assign(**assigned)
        tables.write(tables.CLUSTERS, own, clusters[region])
    names = [("brow", "BrowUp"), ("eye", "EyeWiden"), ("mouth", "Smile")]
    labels = [
        {"region": region, "cluster": number, "action": action, "share": 0.5, "source": source}
        | {"note": note if source == "human" else None, "unmeasured": []}
        for region, name in names
        for number, action, source in ((0, "Neutral", "proposed"), (1, name, "human"))
    ]
    shown = [
        {"region": region, "cluster": 1, "kind": kind, "rank": rank, "clip_id": clip}
        | {"start_frame": 30 * rank, "end_frame": 30 * (rank + 1)}
        for region in SERIES_REGIONS
        for rank, kind in enumerate(("medoid", "longest"))
    ]
    profiled = [
        {"region": region, "cluster": number, "n_frames": 30, "n_intervals": 1, "n_clips": 1}
        | {"median_frames": 30, "purity": 0.96, "nearest": 1 - number, "distance": 2.5}
        for region in SERIES_REGIONS
        for number in (0, 1)
    ]
    share = [{"channel": c, "measured": 1, "mean": 0.3, "std": 0.2, "low": 0.0, "high": 0.6}
             for c in CHANNELS]  # fmt: skip
    share[0] |= {"measured": 0.0, "mean": None, "std": None, "low": None, "high": None}
    share[1] |= {"low": 0.1, "high": 0.101}
    origins = [
        {"channel": c, "measured": True, "origin": f"column {c}", "quality": None} for c in CHANNELS
    ]
    origins[0] |= {"measured": False, "origin": "the tracker has no brows"}
    origins[2] |= {"origin": "expression through face.npz", "quality": 0.62}
    losses = [
        {
            "step": step,
            "loss": 1 / step,
            "val_loss": 2 / step,
            "learning_rate": 1e-3,
            "gradient_norm": 0.5,
            "seconds": 1.0,
        }
        for step in range(1, 20)
    ]
    scored = [
        {
            "model": "annotation",
            "variant": variant,
            "part": "all",
            "metric": f"f1_{region}",
            "n": 60,
        }
        | {"value": value, "low": value - 0.02, "high": value + 0.02}
        for variant, value in (("named", 0.91), ("oracle", 0.93), ("gmm", 0.85))
        for region in ("brow", "eye", "mouth", "gaze")
    ]
    scored += [
        {"model": "annotation", "variant": "named", "part": "all", "metric": f"{name}_brow", "n": n}
        | {"value": value, "low": value - 0.1, "high": value + 0.1}
        for name, value, n in (
            ("segment_f1", 0.8, 12),
            ("segment_precision", 0.75, 16),
            ("segment_recall", 0.87, 12),
            ("start_mean", 1.5, 10),
            ("start_bias", -0.52, 10),
            ("end_mean", 2.25, 9),
            ("end_bias", 0.01, 9),
            ("boundary_within_2", 0.8, 19),
        )
    ]
    taken = [
        {"variant": "named", "track": "brow", "truth": truth, "found": found, "frames": n}
        | {"share": n / 30, "low": n / 30 - 0.05, "high": min(n / 30 + 0.05, 1)}
        for truth, row in (("BrowUp", (3, 27)), ("Neutral", (28, 2)))
        for found, n in zip(("Neutral", "BrowUp"), row, strict=True)
    ]
    taken += [
        {"variant": "named", "track": "brow", "truth": truth, "found": "BrowDown", "frames": 0}
        | {"share": 0.0, "low": 0.0, "high": 0.0}
        for truth in ("BrowUp", "Neutral")
    ]
    followed = [
        {"model": "timeline", "variant": variant, "part": "test", "metric": metric, "n": 1}
        | {"value": value, "low": value, "high": value}
        for variant, value in (("request", 0.77), ("empty", 0.31))
        for metric in ("tas", "tas_brow", "var", "fid_fm")
    ]
    checkpoint = at / "checkpoint"
    _write(tables.LOSSES, losses, checkpoint / "log.parquet")
    told = [
        {"clip_id": clip, "source": "catalogue", "number": 0, "text": "She smiles, then talks."},
        {"clip_id": clip, "source": "timeline", "number": 0, "text": "The brows go up."},
    ]
    counts = [("action", "smile", 1), ("action", "talk", 9), ("emotion", "happy", 1)]
    counts += [("attribute", "lighting:soft_light", 1), ("timeline", "BrowUp", 1)]
    attributes = [
        {"kind": kind, "attribute": name, "clips": n, "share": n / 9, "seconds": 2.0 * n}
        for kind, name, n in counts
    ]
    weights = [{"clip_id": clip, "weight": 0.5}, {"clip_id": "other", "weight": 1.5}]
    return {
        "page": at / "report" / "index.html",
        "ledgers": ledgers,
        "catalogue": [clips(at / "catalogue_clips.parquet", [clip, "bad", "short_1"])],
        "data": at,
        "duplicates": _write(tables.DUPLICATES, [], at / "duplicates.parquet"),
        "descriptions": _write(tables.DESCRIPTIONS, told, at / "descriptions.parquet"),
        "attributes": _write(tables.ATTRIBUTES, attributes, at / "attributes.parquet"),
        "weights": _write(tables.WEIGHTS, weights, at / "weights.parquet"),
        "sources": SOURCES,
        "balance": 0.5,
        "fetched": [clips(at / "fetched.parquet", [clip, "bad"], media)],
        "clips": [clips(at / "clips.parquet", [clip], media)],
        "motions": [paths["motion"]],
        "origins": [_write(tables.ORIGINS, origins, at / "origins.parquet")],
        "series": series,
        "clusters": clusters,
        "labels": _write(tables.LABELS, labels, at / "labels.parquet"),
        "exemplars": _write(tables.EXEMPLARS, shown, at / "exemplars.parquet"),
        "profiles": _write(tables.PROFILES, profiled, at / "profiles.parquet"),
        "intervals": [_write(tables.INTERVALS, found, at / "intervals.parquet")],
        "frames": [paths["frames"]],
        "split": _write(
            tables.SPLIT, [{"clip_id": clip, "part": "train", "group": "a"}], at / "parts.parquet"
        ),
        "statistics": _write(tables.STATISTICS, share, at / "statistics.parquet"),
        "annotation_metrics": _write(tables.METRICS, scored, at / "annotation.parquet"),
        "confusion": _write(tables.CONFUSION, taken, at / "confusion.parquet"),
        "labelling": _write(tables.METRICS, looked(), at / "labelling.parquet"),
        "models": ["timeline"],
        "checkpoints": [checkpoint],
        "metrics": [_write(tables.METRICS, followed, at / "metrics.parquet")],
        "generated": [paths["generated"]],
        "truth": truth,
        "face": None,
        "annotate": LIMITS,
        "overlap": 0.5,
        "side": "left",
        "options": OPTIONS,
    }


@pytest.fixture
def empty_run(tmp_path: Path) -> dict:
    """A run through which no clip came: every table is empty and says why."""
    at, why = tmp_path, "no clip came through"
    ledgers = [
        _ledger(at / "catalogue.parquet", "catalogue", [{"clip_id": "bad", "status": "failed"}])
    ]
    ledgers += [_ledger(at / f"{stage}.parquet", stage, []) for stage in ("select", "ingest")]
    series, clusters = {}, {}
    for region in SERIES_REGIONS:
        series[region], clusters[region] = at / f"{region}.parquet", at / f"{region}_c.parquet"
        long = tables.SERIES[region, "left"]
        tables.write(long, tables.empty(long), series[region], f"not measured: {region} channels")
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), clusters[region])
    checkpoint = at / "checkpoint"
    _write(tables.LOSSES, [], checkpoint / "log.parquet", "there is no window to train on")
    kinds = {
        "labels": tables.LABELS,
        "exemplars": tables.EXEMPLARS,
        "profiles": tables.PROFILES,
        "labelling": tables.METRICS,
        "duplicates": tables.DUPLICATES,
        "descriptions": tables.DESCRIPTIONS,
        "attributes": tables.ATTRIBUTES,
        "weights": tables.WEIGHTS,
        "split": tables.SPLIT,
        "annotation_metrics": tables.METRICS,
        "confusion": tables.CONFUSION,
        "statistics": tables.STATISTICS,
    }
    single = {n: _write(t, [], at / f"{n}_e.parquet", f"{n}: {why}") for n, t in kinds.items()}
    shards = {
        "catalogue": tables.CLIPS,
        "fetched": tables.CLIPS,
        "clips": tables.CLIPS,
        "motions": tables.MOTION,
        "origins": tables.ORIGINS,
        "intervals": tables.INTERVALS,
        "frames": tables.FRAMES,
        "metrics": tables.METRICS,
        "generated": tables.MOTION,
    }
    several = {n: [_write(t, [], at / f"{n}_s.parquet", f"{n}: {why}")] for n, t in shards.items()}
    return {
        "page": at / "report" / "index.html",
        "ledgers": ledgers,
        "series": series,
        "clusters": clusters,
        "models": ["timeline"],
        "checkpoints": [checkpoint],
        "truth": None,
        "face": None,
        "annotate": LIMITS,
        "overlap": 0.5,
        "side": "left",
        "data": at,
        "sources": SOURCES,
        "balance": 0.5,
        "options": OPTIONS,
        **single,
        **several,
    }

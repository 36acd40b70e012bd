"""A small run whose clusters can be named: simulated people, some of whose clips have films."""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.exemplars import exemplars
from mimeline.annotation.segment import segment
from mimeline.annotation.series import series
from mimeline.config import Config
from mimeline.media.film import write_film
from mimeline.toy import simulate
from mimeline.vocabulary import SERIES_REGIONS

CONFIG = Config().model_dump()
SMALL = {"brow": 4, "eye": 4, "mouth": 5}  # clusters
HOSTILE = '<img src=x onerror="document.title=1">'  # one clip is called so
FILMED = 4  # clips, of
CLIPS = 8
SIDE = 64  # px
RULES = Path(__file__).parents[3] / "resources" / "proposals.csv"


def make(results: Path) -> None:
    """Write the tables of all stages up to the proposals, as the workflow lays them out."""
    world = simulate(people=3, clips=CLIPS, seed=1)
    names = {world.clips[0].clip_id: HOSTILE}
    motion = world.motion.assign(clip_id=world.motion["clip_id"].replace(names))
    lengths = motion.groupby("clip_id").size()
    media = results / "fetch" / "00" / "media"
    rows = []
    for number, (name, frames) in enumerate(lengths.items()):
        filmed = name != HOSTILE and number <= FILMED
        if filmed:
            write_film(media / f"{name}.mp4", bar_that_wanders(frames, SIDE), Fraction(30))
        rows.append(_clip(name, frames, media / f"{name}.mp4" if filmed else None))
    clips = pd.DataFrame(rows, columns=tables.CLIPS.schema.names)
    for stage in ("catalogue", "select", "fetch", "ingest", "pose"):
        tables.write(tables.CLIPS, clips, results / stage / "00" / "clips.parquet")
    tables.write(tables.MOTION, motion, results / "ingest" / "00" / "motion.parquet")
    for region in SERIES_REGIONS:
        series(
            [results / "pose" / "00" / "clips.parquet"],
            [results / "ingest" / "00" / "motion.parquet"],
            results / "series" / f"{region}.parquet",
            region=region,
            **CONFIG["series"],
        )
        fit(results, region, SMALL[region])
    propose(results)


def fit(results: Path, region: str, n_clusters: int) -> None:
    """Fit a region, perhaps anew."""
    segment(
        results / "series" / f"{region}.parquet",
        results / "segment" / region / "model",
        results / "segment" / region / "clusters.parquet",
        region=region,
        **CONFIG["series"],
        **CONFIG["segment"][region] | {"n_clusters": n_clusters, "max_iter": 4},
    )


def propose(results: Path) -> None:
    """Choose exemplars and propose names for the fits as they are."""
    fits = {region: results / "segment" / region for region in SERIES_REGIONS}
    exemplars(
        series={region: results / "series" / f"{region}.parquet" for region in SERIES_REGIONS},
        clusters={region: fit / "clusters.parquet" for region, fit in fits.items()},
        models={region: fit / "model" for region, fit in fits.items()},
        rules=RULES,
        proposed=results / "label" / "proposed.parquet",
        exemplars=results / "label" / "exemplars.parquet",
        profiles=results / "label" / "profiles.parquet",
        side=CONFIG["series"]["side"],
        **{key: CONFIG["label"][key] for key in ("n_random", "n_further", "seed")},
    )


def bar_that_wanders(frames: int, side: int) -> Iterator[np.ndarray]:
    """Pictures (side, side, 3), each another: a bright bar goes over the dark, once a second."""
    for frame in range(frames):
        picture = np.full((side, side, 3), 30, np.uint8)
        at = (frame % 30) * (side - 8) // 30
        picture[:, at : at + 8] = (240, 200, 60)
        yield picture


def _clip(name: str, frames: int, film: Path | None) -> dict:
    clip = dict.fromkeys(tables.CLIPS.schema.names)
    clip |= {"clip_id": name, "source_id": "s", "start_s": 0.0, "end_s": frames / 30, "shard": 0}
    clip |= {"fps_num": 30, "fps_den": 1, "n_frames": frames}
    clip |= {"actions": [], "emotions": [], "attributes": [], "texts": []}
    if film:
        clip |= {"media": str(film), "width": SIDE, "height": SIDE}
    return clip

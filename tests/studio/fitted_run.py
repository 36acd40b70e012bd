"""A small run whose clusters can be named, and a browser that has opened its page."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.fits import remember
from mimeline.annotation.fitted import CHANNELS_FILE, FINGERPRINT_FILE
from mimeline.annotation.label_file import read_label_file
from mimeline.annotation.series import concatenate
from mimeline.media.film import write_film
from mimeline.studio.answers import Persons
from mimeline.studio.label import Stopwatch, label
from mimeline.studio.labelling import Labelling
from mimeline.studio.pictures import Pictures
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, series_channels

KEY = "the-key"
HOSTILE = '<img src=x onerror="alert(1)">'
FRAMES, FPS = 80, 20  # of a clip; frames per second
TURNS = {"brow": 4, "mouth": 3}  # clusters; each clip goes through them, 10 frames each
FITS = {"brow": "b" * 16, "mouth": "c" * 16}
NAMES = {"brow": ("BrowUp", "BrowDown", "Neutral", None), "mouth": ("Smile", None, "Neutral")}
UNMEASURED = ["MouthFrown"]


def make(results: Path) -> None:
    """Write what the page reads, as the workflow lays it out."""
    names = ["film_1", HOSTILE]
    clips = pd.DataFrame([_clip(name) for name in names], columns=tables.CLIPS.schema.names)
    tables.write(tables.CLIPS, clips, results / "pose" / "00" / "clips.parquet")
    clips["media"] = ["elsewhere/film_1.mp4", None]
    tables.write(tables.CLIPS, clips, results / "fetch" / "00" / "clips.parquet")
    tables.write(tables.MOTION, _motion(names), results / "ingest" / "00" / "motion.parquet")
    shades = (np.full((48, 64, 3), 3 * frame, np.uint8) for frame in range(FRAMES))
    write_film(results / "fetch" / "00" / "media" / "film_1.mp4", shades, Fraction(FPS))
    for region in ("brow", "eye", "mouth"):
        _write_fit(results, region, names)
    _write_labels(results)
    (results / "run.json").write_text(json.dumps({"config": {}, "files": [], "given": []}))


class LabelPage:
    """What a browser that has the cookie asks for; person: who the command was started for."""

    base = "http://127.0.0.1:8000"

    def __init__(self, pictures: Pictures, file: Path, person: str = ""):
        self.file, self.person = file, person
        self.labelling = Labelling(pictures.run, Persons(file, pictures.run))
        app = label(self.labelling, pictures, Stopwatch(), person, KEY)
        self.client = app.test_client()
        self.client.get(f"/?key={KEY}", base_url=self.base)

    def get(self, path: str, **options):
        return self.client.get(path, base_url=self.base, **options)

    def state(self, person: str | None = None) -> dict:
        return self.get("/state" if person is None else f"/state?person={person}").json

    def cluster(self, region: str, number: int, person: str = "") -> dict:
        regions = {r["name"]: r for r in self.state(person)["regions"]}
        return regions[region]["clusters"][number]

    def post(self, body):
        headers = {"Origin": self.base}
        return self.client.post("/answers", json=body, base_url=self.base, headers=headers)

    def answer(self, where, now, was=None, shown=(), person=""):
        """where: (region, cluster). now, was: as `said`."""
        region, cluster = where
        body = {"person": person, "region": region, "cluster": cluster, "shown": list(shown)}
        return self.post(body | {"was": said(was), "now": said(now)})

    def written(self, person: str = "") -> dict:
        return read_label_file(self.labelling.persons.path(person))


def said(answer) -> dict | None:
    """An answer as it is posted: an action, (action, note), a cluster's number, "not sure"."""
    match answer:
        case None:
            return None
        case "not sure":
            return {"action": None, "note": None, "same_as": None}
        case int(cluster):
            return {"action": None, "note": None, "same_as": cluster}
        case (action, note):
            return {"action": action, "note": note, "same_as": None}
    return {"action": answer, "note": None, "same_as": None}


def turned(frames: pd.DataFrame, clusters: int, shift: int = 0) -> pd.DataFrame:
    """The `clusters` table: every 10 frames the next cluster. shift: a fit that numbers others."""
    number = (frames["frame"] // 10 + shift) % clusters
    return frames[["clip_id", "frame"]].assign(cluster=number, margin=1.0)


def refit(results: Path, region: str, shift: int, fingerprint: str) -> None:
    """Fit a region anew: the same clusters by other numbers."""
    path = results / "segment" / region / "clusters.parquet"
    clusters = turned(tables.read(tables.CLUSTERS, path), TURNS[region], shift)
    tables.write(tables.CLUSTERS, clusters, path)
    (results / "segment" / region / "model" / FINGERPRINT_FILE).write_text(fingerprint + "\n")
    remember(results / "label" / "fits", region, fingerprint, clusters)


def _motion(names) -> pd.DataFrame:
    rows = pd.DataFrame(
        [(name, frame) for name in names for frame in range(FRAMES)], columns=["clip_id", "frame"]
    )
    wave = 0.5 + 0.5 * np.sin(rows["frame"] / 6)
    channels = {name: wave if name in EXPRESSIONS else 0 * wave for name in CHANNELS}
    rows = rows.assign(valid=rows["frame"] != 12, confidence=1.0, tracker_loss=None)
    return rows.join(pd.DataFrame(channels))


def _write_fit(results: Path, region: str, names) -> None:
    folder, series = results / "segment" / region, results / "series" / f"{region}.parquet"
    table, channels = tables.SERIES[region, "left"], list(series_channels(region, "left"))
    if region not in FITS:
        tables.write(tables.CLUSTERS, tables.empty(tables.CLUSTERS), folder / "clusters.parquet")
        tables.write(table, tables.empty(table), series, f"not measured: {channels[0]}")
        return
    motion = _motion(names)
    frames = motion[motion["valid"]]
    clusters = turned(frames, TURNS[region])
    tables.write(table, concatenate(frames, channels, 5, -1.0), series)
    tables.write(tables.CLUSTERS, clusters, folder / "clusters.parquet")
    (folder / "model").mkdir()
    (folder / "model" / CHANNELS_FILE).write_text(json.dumps(channels[:-1]))
    (folder / "model" / FINGERPRINT_FILE).write_text(FITS[region] + "\n")
    remember(results / "label" / "fits", region, FITS[region], clusters)


def _write_labels(results: Path) -> None:
    proposed, profiles, exemplars = [], [], []
    for region, number in [(region, n) for region, all_ in TURNS.items() for n in range(all_)]:
        action = NAMES[region][number]
        unmeasured = UNMEASURED if region == "mouth" else []
        sure = None if action is None else 0.6 + 0.1 * number
        why = "nothing is known of it" if action is None else None
        share = 1 / TURNS[region]
        proposed.append((region, number, action, None, "proposed", share, sure, why, unmeasured))
        profiles.append((region, number, 40, 4, 2, 10.0, 0.9, (number + 1) % 3, 0.5))
        for rank, kind in enumerate(("medoid", "random", "further")):
            clip_id, start = (
                (HOSTILE, "film_1")[rank % 2],
                10 * (number + TURNS[region] * (rank // 2)),
            )
            exemplars.append((region, number, clip_id, start, start + 10, kind, rank))
    for name, table, rows in (
        ("proposed", tables.LABELS, proposed),
        ("profiles", tables.PROFILES, profiles),
        ("exemplars", tables.EXEMPLARS, exemplars),
    ):
        rows = pd.DataFrame(rows, columns=table.schema.names)
        tables.write(table, rows, results / "label" / f"{name}.parquet")


def _clip(name: str) -> dict:
    clip = dict.fromkeys(tables.CLIPS.schema.names)
    clip |= {"clip_id": name, "source_id": name, "start_s": 0.0, "end_s": FRAMES / FPS, "shard": 0}
    clip |= {"actions": [], "emotions": [], "attributes": [], "texts": []}
    return clip | {"fps_num": FPS, "fps_den": 1, "n_frames": FRAMES}

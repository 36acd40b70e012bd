"""A small run whose timelines can be judged, and a browser that has opened its page."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.media.film import write_film
from mimeline.studio.rate import Faces, rate
from mimeline.studio.rated import Rated
from mimeline.studio.rating_file import read_ratings
from mimeline.studio.study import Study
from mimeline.studio.timelines_of_run import TimelinesOfRun
from mimeline.vocabulary import ACTIONS, CHANNELS, EXPRESSIONS

KEY = "the-key"
FRAMES, FPS = 24, 20  # of a clip; frames per second
CLIPS = ("-clip_0", "clip_1", "clip_2", "clip_3", "clip_4", "clip_5", "clip_6", "clip_7")
TESTED = CLIPS[:3]  # the test part; motion was generated for these
FILMED = CLIPS[2:6]
UNMEASURED = ("GazeUp", "GazeDown")  # by the annotation; truth has them
UNTOLD = "MouthFrown"  # by the annotation, whose other actions of the mouth are known
LOST = 6  # a frame that was not tracked
UNMOVED = "cheekPuff"  # the model has no such channel


def make(results: Path) -> None:
    """Write what the page reads, as the workflow lays it out."""
    clips = pd.DataFrame([_clip(name) for name in CLIPS], columns=tables.CLIPS.schema.names)
    for stage in ("catalogue", "pose"):
        tables.write(tables.CLIPS, clips, results / stage / "00" / "clips.parquet")
    media = results / "fetch" / "00" / "media"
    clips["media"] = [f"elsewhere/{name}.mp4" if name in FILMED else None for name in CLIPS]
    tables.write(tables.CLIPS, clips, results / "fetch" / "00" / "clips.parquet")
    for name in FILMED:
        shades = (np.full((48, 64, 3), 9 * frame, np.uint8) for frame in range(FRAMES))
        write_film(media / f"{name}.mp4", shades, Fraction(FPS))
    tables.write(tables.MOTION, motion(CLIPS, 6.0), results / "ingest" / "00" / "motion.parquet")
    write_timelines(results)
    made = motion(TESTED, 3.0).assign(valid=True, **{UNMOVED: np.nan})
    tables.write(tables.MOTION, made, results / "evaluate" / "timeline" / "generated.parquet")
    tables.write(tables.FRAMES, marks(2), results / "toy" / "truth" / "frames.parquet")
    parts = ["test" if name in TESTED else "train" for name in CLIPS]
    split = pd.DataFrame({"clip_id": CLIPS, "part": parts, "group": CLIPS})
    tables.write(tables.SPLIT, split, results / "split" / "split.parquet")
    (results / "run.json").write_text(json.dumps({"config": {}, "files": [], "given": []}))


def write_timelines(results: Path, shift: int = 0) -> None:
    """Annotate. shift: as another fit finds them."""
    found = marks(shift)
    found.loc[found["frame"] == LOST, list(ACTIONS)] = pd.NA
    found[list(UNMEASURED)] = pd.NA
    found[UNTOLD] = found[UNTOLD].mask(~found[UNTOLD])
    tables.write(tables.FRAMES, found, results / "annotate" / "00" / "frames.parquet")


def marks(shift: int) -> pd.DataFrame:
    """The `frames` table: clip n raises its brow from frame n + shift on, for eight frames, frowns
    when it stops, and looks up throughout."""
    rows = [(name, frame) for name in CLIPS for frame in range(FRAMES)]
    found = pd.DataFrame(rows, columns=["clip_id", "frame"])
    since = found["frame"] - found["clip_id"].map(CLIPS.index) - shift
    shown = {"BrowUp": since.between(0, 7), "MouthFrown": since.between(8, 9)}
    shown["GazeUp"] = found["frame"] >= 0
    nothing = found["frame"] < 0
    for action in ACTIONS:
        found[action] = shown.get(action, nothing).astype("boolean")
    return found


def motion(names, speed: float) -> pd.DataFrame:
    rows = pd.DataFrame(
        [(name, frame) for name in names for frame in range(FRAMES)], columns=["clip_id", "frame"]
    )
    wave = 0.5 + 0.5 * np.sin(rows["frame"] / speed)
    channels = {name: wave if name in EXPRESSIONS else 0 * wave for name in CHANNELS}
    rows = rows.assign(valid=rows["frame"] != LOST, confidence=1.0, tracker_loss=None)
    return rows.join(pd.DataFrame(channels))


def _clip(name: str) -> dict:
    clip = dict.fromkeys(tables.CLIPS.schema.names)
    clip |= {"clip_id": name, "source_id": name, "start_s": 0.0, "end_s": FRAMES / FPS, "shard": 0}
    clip |= {"actions": [], "emotions": [], "attributes": [], "texts": []}
    return clip | {"fps_num": FPS, "fps_den": 1, "n_frames": FRAMES}


def study(results: Path, pairs: int = 2, seed: int = 0, kinds=()) -> Study:
    return Study(TimelinesOfRun(results), pairs, seed, kinds)


class RatePage:
    """What a browser that has the cookie asks for."""

    base = "http://127.0.0.1:8000"

    def __init__(self, study: Study, file: Path, person: str = "ann", faces: Faces | None = None):
        self.study, self.file = study, file
        self.faces = faces or Faces(study, None)
        app = rate(Rated(file, study, person), self.faces, KEY)
        self.client = app.test_client()
        self.client.get(f"/?key={KEY}", base_url=self.base)

    def get(self, path: str, **options):
        return self.client.get(path, base_url=self.base, **options)

    def state(self) -> dict:
        return self.get("/state").json

    def ids(self) -> list[str]:
        return [pair["id"] for pair in self.state()["pairs"]]

    def post(self, body):
        headers = {"Origin": self.base}
        return self.client.post("/answers", json=body, base_url=self.base, headers=headers)

    def answer(self, pair: str, seconds: float = 9.0, **answers):
        return self.post({"id": pair, "answers": answers, "seconds": seconds})

    def written(self) -> list:
        return read_ratings(self.file)

"""Small runs to review and to label, their pages, and a browser that has opened them."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.exclusions import read_exclusions
from mimeline.studio.clusters_of_run import ClustersOfRun
from mimeline.studio.decisions import Decisions
from mimeline.studio.pictures import Pictures
from mimeline.studio.review import clips_with_films, review

from . import previewed_files, rated_run
from .fitted_run import HOSTILE, LabelPage, make

KEY = "the-key"
FILM = bytes(range(256)) * 8
CLIPS = ("-a_1", "b_1", "c_1", "d_1", "e_1")  # kept twice, turned, too short, without a video
FILMED = ("-a_1", "b_1", "c_1")


@pytest.fixture
def results(made_once, tmp_path) -> Path:
    """Results of catalogue, select, fetch and pose, as the workflow lays them out."""
    return shutil.copytree(made_once, tmp_path / "results")


@pytest.fixture(scope="session")
def made_once(tmp_path_factory) -> Path:
    results = tmp_path_factory.mktemp("reviewed") / "results"
    ledger = []
    _write_clips(results, "catalogue", CLIPS)
    ledger += [_row(name, "catalogue") for name in CLIPS]
    ledger += [_row("d_1", "select", "dropped", "too_short", value=3.2, limit=5.0, unit="s")]
    ledger += [_row(name, "select") for name in CLIPS if name != "d_1"]
    ledger += [_row(name, "fetch") for name in FILMED]
    ledger += [_row("e_1", "fetch", rule="no_video", detail=f"no video of it in {HOSTILE}")]
    turned = {"value": 41.0, "limit": 35.0, "unit": "deg", "first_frame": 30, "last_frame": 44}
    ledger += [_row("c_1", "pose", "dropped", "turned", **turned)]
    ledger += [_row(name, "pose") for name in ("-a_1", "b_1", "e_1")]
    _write_clips(results, "fetch", [name for name in CLIPS if name != "d_1"])
    _write_clips(results, "pose", ["-a_1", "b_1", "e_1"])
    rows = pd.DataFrame(ledger)
    for stage, part in rows.groupby("stage"):
        folder = results / stage if stage == "catalogue" else results / stage / "00"
        tables.write(tables.LEDGER, part, folder / "ledger.parquet")
    media = results / "fetch" / "00" / "media"
    media.mkdir()
    for name in FILMED:
        (media / f"{name}.mp4").write_bytes(FILM)
    (media / "-a_1.wav").write_bytes(b"RIFF")
    (media / "-a_1.json").write_text("{}")
    return results


@pytest.fixture
def exclusions(tmp_path) -> Path:
    return tmp_path / "config" / "exclusions.csv"


@pytest.fixture
def page(results, exclusions):
    """Opens the page anew, as a start of the command does."""

    return lambda: _opened(results, exclusions)


@pytest.fixture(scope="session")
def idle_page(made_once, tmp_path_factory):
    """A page that no test decides on; its exclusions are never begun."""
    return _opened(made_once, tmp_path_factory.mktemp("idle") / "exclusions.csv")


def _opened(results: Path, exclusions: Path) -> "Page":
    client = review(clips_with_films(results), Decisions(exclusions), KEY).test_client()
    client.get(f"/?key={KEY}", base_url=Page.base)
    return Page(client, exclusions)


class Page:
    """What a browser that has the cookie asks for."""

    base = "http://127.0.0.1:8000"

    def __init__(self, client, exclusions: Path):
        self.client, self.exclusions = client, exclusions

    def get(self, path: str, **options):
        return self.client.get(path, base_url=self.base, **options)

    def decide(self, clip_id: str, now, was=(False, None), **options):
        body = {"clip_id": clip_id, "was": _state(was), "now": _state(now)}
        headers = options.pop("headers", {"Origin": self.base})
        return self.client.post(
            "/decisions", json=body, base_url=self.base, headers=headers, **options
        )

    def state(self) -> dict:
        return self.get("/decisions").json

    def listed(self) -> dict:
        return read_exclusions(self.exclusions)


def _state(decision) -> dict:
    return dict(zip(("seen", "reason"), decision, strict=True))


def _row(clip_id: str, stage: str, status: str = "kept", rule: str | None = None, **facts) -> dict:
    row = dict.fromkeys(tables.LEDGER.schema.names)
    return row | {"clip_id": clip_id, "stage": stage, "status": status, "rule": rule} | facts


def _write_clips(results: Path, stage: str, names) -> None:
    rows = [_clip(name, cut=stage != "catalogue" and name in FILMED) for name in names]
    path = results / stage / "00" / "clips.parquet"
    tables.write(tables.CLIPS, pd.DataFrame(rows, columns=tables.CLIPS.schema.names), path)


def _clip(name: str, cut: bool) -> dict:
    spans = [{"name": "head_wagging", "start_s": 1.0, "end_s": 3.0, "uncertainty_s": 1.0}]
    clip = dict.fromkeys(tables.CLIPS.schema.names)
    clip |= {"clip_id": name, "source_id": name[:-2], "start_s": 10.0, "end_s": 16.0, "shard": 0}
    clip |= {"actions": spans, "emotions": [], "attributes": ["male"], "texts": [HOSTILE]}
    if cut:  # where the run was made, not where it lies now
        clip |= {"media": f"elsewhere/{name}.mp4", "fps_num": 30, "fps_den": 1, "n_frames": 180}
        clip |= {"audio": f"elsewhere/{name}.wav", "width": 512, "height": 512}
    return clip


@pytest.fixture(scope="session")
def fitted_once(tmp_path_factory) -> Path:
    """Results up to `exemplars`: brow and mouth have clusters, the eye was never measured."""
    results = tmp_path_factory.mktemp("fitted") / "results"
    make(results)
    return results


@pytest.fixture
def fitted(fitted_once, tmp_path) -> Path:
    return shutil.copytree(fitted_once, tmp_path / "results")


@pytest.fixture
def names(tmp_path) -> Path:
    """The label file."""
    return tmp_path / "labels" / "names.yaml"


@pytest.fixture(scope="session")
def pictures(fitted_once):
    return Pictures(ClustersOfRun(fitted_once), None)


@pytest.fixture(scope="session")
def idle_label_page(pictures, tmp_path_factory) -> LabelPage:
    """A page whose answers no test looks at."""
    return LabelPage(pictures, tmp_path_factory.mktemp("idle") / "names.yaml")


@pytest.fixture
def label_page(pictures, names):
    """Opens the page anew, as a start of the command does; results: others than the usual."""

    def open_page(results: Path | None = None, person: str = "") -> LabelPage:
        own = Pictures(ClustersOfRun(results), None) if results else pictures
        return LabelPage(own, names, person)

    return open_page


@pytest.fixture(scope="session")
def rated_once(tmp_path_factory) -> Path:
    """Results whose timelines can be judged: all kinds of pairs, some with films."""
    results = tmp_path_factory.mktemp("rated") / "results"
    rated_run.make(results)
    return results


@pytest.fixture
def rated(rated_once, tmp_path) -> Path:
    return shutil.copytree(rated_once, tmp_path / "results")


@pytest.fixture(scope="session")
def previewed_once(tmp_path_factory):
    """Files that can be previewed."""
    return previewed_files.make(tmp_path_factory.mktemp("previewed"))

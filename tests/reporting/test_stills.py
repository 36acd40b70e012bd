"""Pictures of clips that were lost before anything was cut."""

import base64
from fractions import Fraction

import cv2
import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.media.film import write_film
from mimeline.reporting import evidence as module
from mimeline.reporting.album import Album
from mimeline.reporting.evidence import evidence
from mimeline.reporting.funnel import Loss
from mimeline.reporting.report import report
from mimeline.reporting.stand_in import stand_in
from mimeline.reporting.stills import stills

HIGH, WIDE, FPS, SECONDS = 64, 128, 10, 12
ASKED = {"max_pixels": 10**7, "max_source_s": 600.0, "max_mb": 100.0, "timeout_s": 60.0}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """A folder of videos: the left half of a source tells the second by its red, the right not."""
    folder = tmp_path_factory.mktemp("data") / "videos"
    folder.mkdir()

    def frames():
        for number in range(SECONDS * FPS):
            frame = np.full((HIGH, WIDE, 3), 128, np.uint8)
            frame[:, : WIDE // 2] = (20 * (number // FPS), 0, 0)
            yield frame

    write_film(folder / "source.mp4", frames(), Fraction(FPS))
    (folder / "broken.mp4").write_text("<html>")
    (folder / "cut.mp4").symlink_to(folder / "source.mp4")
    return folder.parent


def clip(clip_id: str, source: str = "source", start: float = 2.0, end: float = 5.0, **more):
    lists = {"actions": [], "emotions": [], "attributes": [], "texts": [], "shard": 0}
    times = {"clip_id": clip_id, "source_id": source, "start_s": start, "end_s": end}
    return dict.fromkeys(tables.CLIPS.schema.names) | lists | times | more


@pytest.fixture
def pictures(data, tmp_path):
    """Clip → its still as a picture, of the clips given."""

    def pictures(*rows: dict, folder: str | None = "videos") -> dict[str, np.ndarray | None]:
        path = tmp_path / "clips.parquet"
        table = pd.DataFrame(list(rows), columns=tables.CLIPS.schema.names)
        tables.write(tables.CLIPS, table, path)
        wanted = {row["clip_id"] for row in rows}
        found = stills([path], data, wanted, folder=folder, **ASKED)
        return {clip_id: still.picture() for clip_id, still in found.items()}

    return pictures


BOX = {"bbox_top": 0.0, "bbox_bottom": 1.0, "bbox_left": 0.0, "bbox_right": 0.5}


def test_a_still_is_the_middle_of_the_clip_cropped_to_its_box(pictures):
    (still,) = pictures(clip("a", **BOX)).values()
    assert still.shape == (HIGH, WIDE // 2, 3)
    red, green, blue = still.mean(axis=(0, 1))
    assert red == pytest.approx(20 * 3, abs=8)  # the fourth second, from 2 s to 5 s
    assert max(green, blue) < 12


def test_a_box_in_pixels_is_cropped_too(pictures):
    (still,) = pictures(
        clip("a", bbox_top=0, bbox_bottom=64, bbox_left=96, bbox_right=128)
    ).values()
    assert still.shape == (64, 32, 3)
    assert still.mean() == pytest.approx(128, abs=5)


def test_a_video_of_the_clip_itself_counts_from_its_start_and_is_shown_whole(pictures):
    (still,) = pictures(clip("cut", start=100.0, end=103.0, **BOX)).values()
    assert still.shape == (HIGH, WIDE, 3)
    assert still[:, : WIDE // 2, 0].mean() == pytest.approx(20, abs=8)


def test_of_a_source_that_ends_within_the_clip_what_there_is_is_shown(pictures):
    (still,) = pictures(clip("a", start=9.0, end=60.0, **BOX)).values()
    assert still[..., 0].mean() == pytest.approx(200, abs=8)  # the eleventh second


def test_the_video_that_the_catalogue_names_comes_first(pictures):
    found = pictures(clip("cut", video="videos/source.mp4", **BOX), folder=None)
    assert found["cut"].shape == (HIGH, WIDE // 2, 3)


def test_without_a_source_that_can_be_read_there_is_no_picture(pictures, data):
    content = (data / "videos" / "source.mp4").read_bytes()
    (data.parent / "outside.mp4").write_bytes(content)
    found = pictures(
        clip("broken", "broken"),
        clip("late", start=30.0, end=35.0),
        clip("absent", "nowhere"),
        clip("led_out", video="../outside.mp4"),
    )
    assert found == {"broken": None, "late": None}


def lost(clip_id: str, rule: str = "too_short") -> Loss:
    return Loss(clip_id, "select", "dropped", rule, rule, "", "", "", "", None, None)


def test_of_many_lost_clips_the_first_of_each_rule_have_a_still(monkeypatch):
    monkeypatch.setattr(module, "MOST_STILLS", 3)
    losses = [lost(f"s{n}") for n in range(9)] + [lost(f"l{n}", "too_long") for n in range(9)]
    album = Album({}, [], stand_in(None), dict.fromkeys(loss.clip_id for loss in losses))
    assert set(evidence(losses, [], {}, album)) == {"s0", "l0", "s1"}


def test_the_page_shows_a_clip_that_was_lost_before_it_was_cut(run, data):
    arguments = run() | {"data": data}
    arguments["sources"] = arguments["sources"] | {"folder": "videos"}
    table = pd.DataFrame([clip("short_1")], columns=tables.CLIPS.schema.names)
    tables.write(tables.CLIPS, table, arguments["catalogue"][0])
    report(**arguments)
    page = arguments["page"].read_text(encoding="utf-8")
    row = page.partition('<td class="id">short_1')[2].partition("</tr>")[0]
    assert "a frame out of its source" in row
    address = row.partition("data:image/webp;base64,")[2].partition('"')[0]
    content = np.frombuffer(base64.b64decode(address), np.uint8)
    picture = cv2.imdecode(content, cv2.IMREAD_COLOR_RGB)
    assert picture[picture.shape[0] // 2, picture.shape[1] // 4, 0] == pytest.approx(60, abs=10)

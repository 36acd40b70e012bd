import base64
import io
import re
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from mimeline import tables
from mimeline.reporting.album import Album, data_uri, square
from mimeline.reporting.evidence import MOST, evidence
from mimeline.reporting.funnel import funnel
from mimeline.reporting.report import report
from mimeline.reporting.side_by_side import side_by_side
from mimeline.reporting.stand_in import GROUND, stand_in

CLIP, MADE = "kept_1", 10


def seen(uri: str) -> np.ndarray:
    """The picture that an address holds, RGB."""
    content = base64.b64decode(uri.removeprefix("data:image/webp;base64,"), validate=True)
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def filmed(html: str) -> list[tuple[int, int]]:
    """Of each picture that the page calls filmed: its frame, and the one that the film shows."""
    found = re.findall(r'<img src="([^"]+)"[^>]* alt="frame (\d+), filmed"', html)
    return [(int(frame), round((seen(uri)[..., 1].mean() - 20) / 3)) for uri, frame in found]


def written(arguments: dict) -> str:
    report(**arguments)
    return arguments["page"].read_text(encoding="utf-8")


@pytest.fixture
def album(run):
    """Makes an album of the run's motions: media (clip → video) and a face."""
    motions = run()["motions"]
    return lambda media=None, face=None: Album(media or {}, motions, stand_in(face))


def test_every_exemplar_has_a_picture_of_its_first_middle_and_last_frame(plain_page):
    figures = re.findall(r'<div class="shots".*?</div>', plain_page, flags=re.DOTALL)
    assert [plain_page.count(f'aria-label="{k} interval') for k in ("medoid", "longest")] == [3, 3]
    frames = [re.findall(r'alt="frame (\d+), drawn"', figure) for figure in figures]
    assert frames == [["0", "14", "29"], ["30", "44", "59"]] * 3


def test_the_frames_of_a_clips_video_are_on_the_page(filmed_page):
    shown = filmed(filmed_page)
    assert {0, 14, 29, 30} <= {frame for frame, _ in shown}  # an exemplar's three, and the sheet's
    assert all(abs(frame - number) <= 1 for frame, number in shown)
    assert '<ul class="sheet">' in filmed_page and 'class="holes"' in filmed_page
    assert "a frame of the clip’s video" in filmed_page


def test_an_exemplar_that_was_filmed_is_seen_filmed_and_drawn_close(filmed_page):
    figure = re.findall(r'<div class="shots".*?</div>', filmed_page, flags=re.DOTALL)[0]
    seen = re.findall(r'alt="frame (\d+), (\w+)"', figure)
    assert seen == [(f, way) for way in ("filmed", "drawn") for f in ("0", "14", "29")]


def test_without_a_video_nothing_is_called_filmed(plain_page):
    assert "filmed" not in plain_page.partition("</style>")[2]
    assert '<ul class="sheet">' not in plain_page


@pytest.mark.parametrize("content", [None, b"", b"<!doctype html><p>not found"])
def test_a_video_that_is_gone_or_broken_is_drawn_and_said(run, tmp_path, content):
    path = tmp_path / "gone.mp4"
    if content is not None:
        path.write_bytes(content)
    html = written(run(media={CLIP: path}))
    assert f"the film of 1 clip ({CLIP}) cannot be shown: the motion is drawn instead" in html
    assert 'alt="frame 14, drawn"' in html and "frame 14, filmed" not in html
    assert "snakemake -R fetch" in html
    assert '<ul class="sheet">' not in html


def test_a_lost_clip_is_seen_where_it_was_lost(filmed_page):
    lost = filmed_page.partition('<table class="rows losses">')[2].partition("</table>")[0]
    assert [frame for frame, _ in filmed(lost)] == [3]  # its tracking is unreadable from there on


def test_a_head_that_turns_is_seen_where_it_turns_farthest(run, ledger, tmp_path, album):
    arguments = run()
    motion = tables.read(tables.MOTION, arguments["motions"][0])
    motion["head_yaw_left"] = np.where(motion["frame"] == 41, -0.9, 0.1).astype("float32")
    tables.write(tables.MOTION, motion, arguments["motions"][0])
    span = {"first_frame": 39, "last_frame": 45, "value": 51.6, "limit": 35.0, "unit": "deg"}
    row = {"clip_id": CLIP, "status": "dropped", "rule": "turned"} | span
    way = funnel([ledger(tmp_path / "a", "catalogue", [row])])
    book = album()
    shots = evidence(way.losses, arguments["motions"], {}, book)
    book.develop()
    assert shots[CLIP].frame == 41
    assert not book.get(shots[CLIP]).filmed


def test_of_many_lost_clips_the_first_of_each_rule_is_shown(ledger, tmp_path, album):
    lost = [
        {"clip_id": f"{rule}{number:03d}", "status": "dropped", "rule": rule, "first_frame": 1}
        for rule in ("turned", "tracking_lost")
        for number in range(MOST)
    ]
    way = funnel([ledger(tmp_path / "a", "catalogue", lost)])
    assert set(evidence(way.losses, [], {}, album())) == {"turned000", "tracking_lost000"}


def test_a_frame_that_was_not_measured_is_not_drawn(run, album):
    path = run()["motions"][0]
    motion = tables.read(tables.MOTION, path)
    tables.write(tables.MOTION, motion.assign(valid=motion["frame"] != 7), path)
    book = album()
    masked, known, absent = book.ask(CLIP, 7), book.ask(CLIP, 8), book.ask("nobody", 8)
    book.develop()
    assert book.get(known) and not book.get(masked) and not book.get(absent)


def test_a_drawn_face_does_what_the_motion_says(run):
    actor = stand_in(None)
    motion = tables.read(tables.MOTION, run()["motions"][0]).head(2)
    motion[list(motion.columns[5:])] = 0.0
    motion.loc[1, "jawOpen"] = 1.0
    rest, open_mouth = actor.pictures(motion, 64)
    upper, lower = np.abs(rest.astype(int) - open_mouth).reshape(2, 32, 64, 3).mean(axis=(1, 2, 3))
    assert lower > 3 * upper
    motion.loc[1, "head_yaw_left"] = 0.6
    still, open_close = actor.pictures(motion, 64, region="brow")
    assert np.abs(still.astype(int) - open_close).mean() < 1  # head held still, mouth not seen
    assert (np.abs(rest[0, 0].astype(int) - GROUND) < 3).all()


@pytest.mark.parametrize("content", [b"", b"no face at all"])
def test_a_face_that_cannot_be_read_is_stood_in_for(run, tmp_path, content):
    path = tmp_path / "face.npz"
    path.write_bytes(content)
    html = written(run() | {"face": path})
    assert "the embedded face stands in" in html and "face.npz" in html
    assert 'alt="frame 14, drawn"' in html


def test_the_films_of_made_motion_play(plain_page):
    films = re.findall(r'<video src="data:video/mp4;base64,([A-Za-z0-9+/=]+)"', plain_page)
    assert len(films) == 1
    with av.open(io.BytesIO(base64.b64decode(films[0]))) as film:
        stream = film.streams.video[0]
        assert stream.codec_context.name == "h264" and stream.average_rate == 30
        assert sum(1 for _ in film.decode(stream)) == MADE


def test_a_film_shows_both_faces_and_a_line_that_runs_through_the_timeline(run):
    motion = tables.read(tables.MOTION, run()["motions"][0])
    runs = [[("BrowUp", 0, 5)], []]
    made = side_by_side(
        stand_in(None), motion, motion.assign(valid=False), runs, 8, Fraction(25), [0, 7]
    )
    with av.open(io.BytesIO(base64.b64decode(made.film.partition(",")[2]))) as film:
        pictures = [f.to_ndarray(format="rgb24").astype(int) for f in film.decode(video=0)]
    assert (len(pictures), pictures[0].shape) == (8, (made.height, made.width, 3))
    bright = [int(picture[60, 430:760].sum(axis=1).argmax()) for picture in pictures]
    assert bright == sorted(set(bright))
    assert pictures[0][30:200, 20:190].std() > 20 > pictures[0][30:200, 220:390].std()
    assert all(made.strips["made"]) and not any(made.strips["real"])


def test_of_a_picture_that_is_not_square_nothing_is_cut_off():
    wide = np.full((40, 80, 3), 200, np.uint8)
    fitted = square(wide, 16)
    assert (fitted[4:12] == 200).all() and (fitted[[0, -1]] < 50).all()
    fitted = square(wide.transpose(1, 0, 2), 16)
    assert (fitted[:, 4:12] == 200).all() and (fitted[:, [0, -1]] < 50).all()
    assert seen(data_uri(fitted)).shape == (16, 16, 3)


def test_the_page_stays_small(filmed_page):
    assert len(filmed_page) < 1_500_000

import csv
import json
import os
import re
import time
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from http.cookiejar import CookieJar
from pathlib import Path

import cv2
import numpy as np
import pytest

from mimeline import cli
from mimeline.errors import BadConfig, BadFile
from mimeline.reporting.stand_in import GROUND
from mimeline.studio.rate import COLUMNS, EDGE, Faces, closing, opening, own_file
from mimeline.studio.rated import Rated
from mimeline.studio.rating_file import QUESTIONS, read_ratings
from mimeline.studio.timelines_of_run import KINDS
from mimeline.vocabulary import TRACKS

from .browser.served import Served
from .rated_run import CLIPS, FPS, FRAMES, LOST, RatePage, study, write_timelines

CHECKOUT = Path(__file__).parents[2]
REAL = ("truth", "annotation", "mismatched")


@pytest.fixture(scope="module")
def drawn(rated_once):
    return study(rated_once)


@pytest.fixture(scope="module")
def filmed(rated_once):
    return study(rated_once, kinds=REAL)


@pytest.fixture
def answers(tmp_path) -> Path:
    return tmp_path / "ratings" / "answers.csv"


@pytest.fixture(scope="module")
def faces(drawn):
    """Drawn once for all tests."""
    faces = Faces(drawn, None)
    yield faces
    faces.end()


@pytest.fixture
def page(drawn, answers, faces):
    return RatePage(drawn, answers, faces=faces)


def told(page: RatePage) -> list[bytes]:
    """All that the page is told, heads and bodies."""
    paths = ["/", "/state"]
    for name in page.ids():
        paths += [f"/pairs/{name}", f"/sheet/{name}", f"/media/film/{name}"]
    found = [page.get(path) for path in paths]
    found.append(page.answer(page.ids()[0], accurate=4))
    return [repr(list(answer.headers)).encode() + answer.data for answer in found]


def test_nothing_that_the_page_is_told_holds_a_kind_or_a_clip(page):
    for answer in told(page):
        assert not [word for word in (*KINDS, *CLIPS) if word.encode() in answer]


def test_of_films_the_page_is_told_no_kind_or_clip_either(filmed, answers):
    for answer in told(RatePage(filmed, answers)):
        assert not [word for word in (*KINDS, *CLIPS) if word.encode() in answer]


def test_the_state_has_the_questions_the_points_and_the_persons_own_order(page, drawn):
    state = page.state()
    assert [q["name"] for q in state["questions"]] == ["accurate", "natural"]
    assert [(p["value"], p["key"]) for p in state["points"]] == [
        (n, str(n)) for n in range(5, 0, -1)
    ]
    assert page.ids() == [pair.id for pair in drawn.order("ann")]
    assert page.ids() != RatePage(drawn, page.file, "bo", page.faces).ids()
    assert all(pair["answers"] == {} for pair in state["pairs"])


def test_a_pair_has_its_eight_tracks_and_its_clock(page):
    pair = page.get(f"/pairs/{page.ids()[0]}").json
    assert [track["name"] for track in pair["tracks"]] == list(TRACKS)
    assert (pair["fps"], pair["n_frames"], pair["seconds"]) == (FPS, FRAMES, FRAMES / FPS)
    brow = pair["tracks"][0]["intervals"][0]
    assert brow["words"] == "Brow up" and brow["colour"].startswith("#")
    unmeasured = [track for track in pair["tracks"] if not track["measured"]]
    assert [(t["name"], t["intervals"]) for t in unmeasured] == [("gaze_v", [])]


def test_a_drawn_pair_has_a_sheet_with_a_face_for_each_frame(page):
    name = page.ids()[0]
    pair = page.get(f"/pairs/{name}").json
    assert pair["view"] == "face" and pair["film"] is None
    assert pair["sheet"] == {"edge": EDGE, "columns": COLUMNS, "frames": list(range(FRAMES))}
    sheet = _sheet(page, name)
    assert sheet.shape == (2 * EDGE, COLUMNS * EDGE, 3)
    tiles = [_tile(sheet, frame) for frame in range(FRAMES)]
    ground = np.array(GROUND[::-1], float)
    assert all(np.abs(tile - ground).mean() > 2 for tile in tiles)
    assert np.abs(_tile(sheet, FRAMES) - ground).mean() < 1  # what is left of the last row
    assert _apart(tiles[LOST], tiles[LOST - 1]) < _apart(tiles[LOST + 1], tiles[LOST - 1])


def test_generated_motion_is_drawn_other_than_the_clips_own(page, drawn):
    made = next(pair for pair in drawn.pairs.values() if pair.kind == "generation")
    frames = list(range(FRAMES))
    pictures = dict(page.faces._drawn(made.id, frames))
    real = drawn.run.motion([made.clip_id])
    of_clip = next(page.faces._actor.pictures(real[real["frame"] == 20], EDGE))
    assert _apart(pictures[20], of_clip) > 1


def test_a_filmed_pair_has_its_clips_film_and_parts_of_it(filmed, answers):
    page = RatePage(filmed, answers)
    name = page.ids()[0]
    pair = page.get(f"/pairs/{name}").json
    assert pair["view"] == "film" and pair["sheet"] is None
    film = filmed.pairs[name].film.read_bytes()
    assert page.get(pair["film"]).data == film
    part = page.get(pair["film"], headers={"Range": "bytes=10-19"})
    assert part.status_code == 206 and part.data == film[10:20]
    assert page.get(f"/sheet/{name}").status_code == 404


def test_what_comes_next_is_drawn_before_it_is_asked_for(drawn, answers):
    page = RatePage(drawn, answers)
    ahead = page.ids()[:3]
    page.get(f"/pairs/{ahead[0]}")
    until = time.monotonic() + 60
    while not all(map(page.faces.is_drawn, ahead)) and time.monotonic() < until:
        time.sleep(0.01)
    assert [page.faces.is_drawn(name) for name in page.ids()[:4]] == [True, True, True, False]
    page.faces.end()


def test_long_and_fast_clips_are_shown_at_fewer_frames(drawn, monkeypatch):
    faces, pair = Faces(drawn, None), next(iter(drawn.pairs.values()))
    monkeypatch.setattr(drawn, "fps", lambda _: 60)
    assert faces.frames(pair) == list(range(0, FRAMES, 2))
    monkeypatch.setattr(drawn, "n_frames", lambda _: 6000)
    frames = faces.frames(pair)
    assert len(frames) <= 320 and frames[0] == 0 and frames[-1] >= 6000 - 20


def test_an_answer_is_in_the_file_at_once(page, drawn):
    first = page.ids()[0]
    answer = page.answer(first, seconds=12.34, accurate=4, natural=5)
    assert answer.status_code == 200
    assert answer.json["done"] == 1 and answer.json["of"] == len(drawn.pairs)
    rows = list(csv.DictReader(page.file.read_text().splitlines()))
    pair = drawn.pairs[first]
    assert [(r["question"], r["answer"], r["seconds"]) for r in rows] == [
        ("accurate", "4", "12.3"),
        ("natural", "5", "12.3"),
    ]
    assert {(r["person"], r["pair"], r["kind"], r["view"]) for r in rows} == {
        ("ann", first, pair.kind, "face")
    }
    assert {r["results"] for r in rows} == {drawn.results}


def test_a_second_answer_takes_the_firsts_place(page):
    first, second, *_ = page.ids()
    page.answer(first, accurate=4, natural=5)
    page.answer(second, accurate=1)
    assert page.answer(first, accurate=2).json["done"] == 1
    told = [(r.pair, r.question, r.answer) for r in page.written()]
    assert told == [(first, "accurate", 2), (first, "natural", 5), (second, "accurate", 1)]
    assert page.state()["pairs"][0]["answers"] == {"accurate": 2, "natural": 5}


def test_a_question_answered_later_stands_beside_the_other(page):
    first, second, *_ = page.ids()
    page.answer(first, accurate=4)
    page.answer(second, accurate=3)
    page.answer(first, natural=1)
    assert [r.pair for r in page.written()] == [first, first, second]


def test_an_answer_can_be_taken_back(page):
    first = page.ids()[0]
    page.answer(first, accurate=4, natural=5)
    assert page.answer(first, accurate=None).json["done"] == 0
    assert [(r.question, r.answer) for r in page.written()] == [("natural", 5)]
    page.answer(first, natural=None)
    assert page.written() == [] and page.state()["pairs"][0]["answers"] == {}


def test_that_there_is_no_picture_is_an_answer_and_said_in_the_end(page, drawn):
    first = page.ids()[0]
    unseen = page.state()["unseen"]
    assert page.answer(first, accurate=unseen, natural=unseen).json["done"] == 1
    assert [(r.question, r.answer) for r in page.written()] == [("accurate", 0), ("natural", 0)]
    said = closing(Rated(page.file, drawn, "ann"))
    assert (
        "1 of 8 pairs are answered. Of 1 there was no picture: the rows whose answer is 0" in said
    )


def test_a_person_goes_on_after_a_restart(drawn, rated_once, page):
    first = page.ids()[0]
    page.answer(first, accurate=4, natural=5)
    again = RatePage(study(rated_once), page.file)
    assert again.ids() == page.ids()
    assert again.state()["pairs"][0] == {"id": first, "answers": {"accurate": 4, "natural": 5}}


def test_persons_share_a_file_and_do_not_see_each_others_answers(drawn, page):
    other = RatePage(drawn, page.file, "bo", page.faces)
    first = page.ids()[0]
    page.answer(first, accurate=4, natural=5)
    assert all(pair["answers"] == {} for pair in other.state()["pairs"])
    other.answer(first, accurate=1, natural=2)
    page.answer(page.ids()[1], accurate=3)
    assert [r.person for r in page.written()] == ["ann"] * 3 + ["bo"] * 2


def test_no_answer_is_lost_when_two_pages_write_at_once(drawn, page):
    pages = [
        page,
        RatePage(drawn, page.file, "bo", page.faces),
        RatePage(drawn, page.file, "cem", page.faces),
    ]

    def work(page):
        return [page.answer(name, accurate=4, natural=4).status_code for name in page.ids()]

    with ThreadPoolExecutor() as pool:
        assert {code for codes in pool.map(work, pages) for code in codes} == {200}
    assert len(page.written()) == 3 * 2 * len(drawn.pairs)


@pytest.mark.parametrize(
    "body",
    [
        {},
        [],
        {"id": "x", "answers": {}, "seconds": 1},
        {"id": "x", "answers": {"accurate": 6}, "seconds": 1},
        {"id": "x", "answers": {"accurate": -1}, "seconds": 1},
        {"id": "x", "answers": {"accurate": 4.0}, "seconds": 1},
        {"id": "x", "answers": {"accurate": True}, "seconds": 1},
        {"id": "x", "answers": {"pretty": 4}, "seconds": 1},
        {"id": "x", "answers": {"accurate": 4}, "seconds": -1},
        {"id": "x", "answers": {"accurate": 4}, "seconds": "1"},
        {"id": "x", "answers": {"accurate": 4}, "seconds": True},
        {"id": "x", "answers": {"accurate": 4}, "seconds": float("nan")},
        {"id": "x", "answers": {"accurate": 4}},
    ],
)
def test_an_answer_that_is_none_is_refused(page, body):
    if isinstance(body, dict) and "id" in body:
        body = body | {"id": page.ids()[0]}
    assert page.post(body).status_code == 400 and not page.file.exists()


def test_a_pair_that_is_none_is_not_there(page):
    assert page.answer("0" * 12, accurate=4).status_code == 404
    for path in ("pairs", "sheet", "media/film"):
        assert page.get(f"/{path}/{'0' * 12}").status_code == 404


def test_answers_of_other_results_are_not_mixed(page, rated):
    page.answer(page.ids()[0], accurate=4)
    write_timelines(rated, shift=1)
    with pytest.raises(BadFile, match="other results.*another --file"):
        Rated(page.file, study(rated), "ann")


def test_a_page_whose_results_change_says_so(rated, answers):
    page = RatePage(study(rated), answers)
    first = page.ids()[0]
    write_timelines(rated, shift=1)
    for answer in (page.get("/state"), page.get(f"/pairs/{first}"), page.answer(first, accurate=4)):
        assert answer.status_code == 500 and "the run went on" in answer.text
    assert not answers.exists()


def test_a_file_that_was_spoilt_meanwhile_is_not_written_over(page):
    first, second, *_ = page.ids()
    page.answer(first, accurate=4)
    page.file.write_text("no answers at all\n")
    answer = page.answer(second, accurate=4)
    assert answer.status_code == 500 and "answers.csv" in answer.text
    assert page.file.read_text() == "no answers at all\n"


def test_cells_that_would_be_formulas_are_harmless_and_come_back(page, drawn):
    for name in page.ids():
        page.answer(name, accurate=3)
    dashed = [r for r in page.written() if r.clip_id == CLIPS[0]]
    assert dashed
    for row in csv.reader(page.file.read_text().splitlines()):
        assert not [cell for cell in row if cell[:1] in "=+-@" and cell]


@pytest.mark.parametrize("name", ["", " ", "=1+1", "@ann", "two\nlines", "x" * 41])
def test_a_persons_name_that_is_none_is_a_plain_error(drawn, answers, name):
    with pytest.raises(BadConfig, match="--person"):
        Rated(answers, drawn, name)


def test_what_there_is_to_judge_and_what_is_lacking_is_said(drawn, rated):
    assert "8 pairs: 2 truth, 2 annotation, 2 generation and 2 mismatched, as drawn" in opening(
        drawn
    )
    (rated / "evaluate" / "timeline" / "generated.parquet").unlink()
    said = opening(study(rated))
    assert "None of kind generation: no motion was generated" in said and "films" in said


def test_generated_motion_that_is_older_than_the_timelines_is_said(drawn, rated):
    assert "older" not in opening(drawn)
    write_timelines(rated)
    generated = rated / "evaluate" / "timeline" / "generated.parquet"
    os.utime(generated, (0, 0))
    assert "The generated motion is older than the timelines" in opening(study(rated))
    assert "older" not in opening(study(rated, kinds=REAL))


def test_the_end_says_where_the_answers_are_and_what_reads_them(drawn, tmp_path):
    rated = Rated(tmp_path / "my answers.csv", drawn, "ann")
    assert closing(rated).strip() == "0 of 8 pairs are answered."
    rated.answer(next(iter(drawn.pairs.values())), dict.fromkeys(QUESTIONS, 4), 3.0)
    said = closing(rated)
    assert "1 of 8 pairs" in said and f"mimeline ratings '{tmp_path}/my answers.csv'" in said


def test_the_manual_names_every_option_and_key(page):
    manual = (CHECKOUT / "docs" / "rating.md").read_text(encoding="utf-8")
    offered = cli._parser()._subparsers._group_actions[0].choices["rate"].format_help()
    options = set(re.findall(r"--[a-z-]+", offered)) - {"--help"}
    assert options <= set(re.findall(r"^\| `(--[a-z-]+)", manual, re.MULTILINE))
    help = page.get("/").text.partition('id="help"')[2].partition("</dl>")[0]
    keys = re.findall(r"<kbd>(.+?)</kbd>", help)
    assert len(keys) > 10 and not [key for key in keys if f"`{key}`" not in manual]


def test_a_file_is_named_after_the_results():
    assert own_file(Path("results-toy")) == Path("config/ratings/toy.csv")
    assert own_file(Path("results")) == Path("config/ratings/results.csv")


def test_the_command_serves_goes_on_and_ends(rated_once, answers):
    words = ("rate", "--results", rated_once, "--person", "ann", "--pairs", 1, "--file")
    served = Served(answers.parent.parent, *words, file=answers)
    try:
        browser = urllib.request.build_opener(
            urllib.request.HTTPCookieProcessor(CookieJar()), urllib.request.ProxyHandler({})
        )
        base = served.address.partition("/?")[0]
        with pytest.raises(urllib.error.HTTPError, match="403"):
            browser.open(f"{base}/state")
        browser.open(served.address)
        pairs = json.load(browser.open(f"{base}/state"))["pairs"]
        body = {"id": pairs[0]["id"], "answers": {"accurate": 5, "natural": 2}, "seconds": 4}
        headers = {"Origin": base, "Content-Type": "application/json"}
        post = urllib.request.Request(f"{base}/answers", json.dumps(body).encode(), headers)
        assert json.load(browser.open(post))["of"] == len(pairs) == 4
    finally:
        said = served.end()
    assert "1 of 4 pairs are answered" in said and f"mimeline ratings {answers}" in said
    assert [r.answer for r in read_ratings(answers)] == [5, 2]


def _sheet(page: RatePage, name: str) -> np.ndarray:
    answer = page.get(f"/sheet/{name}")
    assert answer.mimetype == "image/jpeg"
    return cv2.imdecode(np.frombuffer(answer.data, np.uint8), cv2.IMREAD_COLOR)


def _tile(sheet: np.ndarray, place: int) -> np.ndarray:
    row, column = divmod(place, COLUMNS)
    return sheet[row * EDGE : (row + 1) * EDGE, column * EDGE : (column + 1) * EDGE].astype(float)


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one.astype(float) - other.astype(float)).mean())

"""The rating page, clicked through: what a person answers is on disk, and what they must not know
is nowhere."""

import csv
import re
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Self

import pytest
from playwright.sync_api import Locator, expect
from werkzeug.serving import make_server

from mimeline.studio import rate as rating
from mimeline.studio import server
from mimeline.studio.rated import Rated
from mimeline.studio.study import Study
from mimeline.vocabulary import TRACKS

from ..rated_run import study
from .tabs import MOST_MS, POLL_MS, Tabs, take_picture, until

Shown = tuple[Study, rating.Faces]
KINDS = ("truth", "annotation", "generation", "mismatched")
REAL = ("truth", "annotation", "mismatched")
QUESTIONS = ("accurate", "natural")
FACE = "document.getElementById('face').toDataURL()"
SHADE = """(() => {
    const film = document.querySelector('#picture video:not([hidden])');
    const brush = new OffscreenCanvas(1, 1).getContext('2d');
    brush.drawImage(film, 0, 0, 1, 1);
    return brush.getImageData(0, 0, 1, 1).data[1];
})()"""
BOXES = """[...document.querySelectorAll('button, .track')]
    .filter((one) => one.checkVisibility())
    .map((one) => {
        const { left, right, top, bottom } = one.getBoundingClientRect();
        return { left, right, top: top + scrollY, bottom: bottom + scrollY, is: one.outerHTML };
    })"""
CUT = """[...document.querySelectorAll('.question span, .question h2')]
    .filter((one) => one.clientWidth && one.scrollWidth > one.clientWidth + 1)
    .map((one) => one.textContent)"""
A_FRAME = 9  # the films of the small run are a shade lighter with every frame


class Serving:
    """The page as a thread serves it: the command takes seconds to start, and test_rate runs it.

    key, port: as those of the command, which makes a key of its own and takes any free port.
    """

    def __init__(self, shown: Shown, file: Path, key: str = "a-key", port: int = 0):
        self.file = file
        study, faces = shown
        app = rating.rate(Rated(file, study, "ann"), faces, key)
        self._server = make_server(server.HOST, port, app, threaded=True)
        self._server.daemon_threads = True
        self.port = self._server.server_port
        self.address = f"http://{server.HOST}:{self.port}/?{server.KEY}={key}"
        self._thread = threading.Thread(target=self._server.serve_forever)
        self._thread.start()

    def end(self) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


class RatePage:
    """The page in a tab, as long as nobody has answered anything, and the file that it writes."""

    def __init__(self, served: Serving, tabs: Tabs):
        served.file.unlink(missing_ok=True)
        self.file = served.file
        self.page = tabs.open(served.address)
        expect(self.page.locator("#intro")).to_be_visible()

    def begin(self) -> Self:
        self.page.get_by_role("button", name="Begin").click()
        self.shows(1)
        return self

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def shows(self, number: int) -> None:
        """Wait until the pair of that number is shown, with its picture."""
        expect(self.page.locator("#place")).to_have_text(re.compile(rf"{number} of \d+"))
        expect(self.page.locator("#no-picture")).to_be_hidden()

    @property
    def pairs(self) -> int:
        return int(self.page.locator("#place").inner_text().split(" of ")[1])

    @property
    def frame(self) -> int:
        """Where the playhead is."""
        return int(self.page.locator("#seek").input_value())

    @property
    def frames(self) -> int:
        return int(self.page.locator("#seek").get_attribute("max")) + 1

    def stop(self) -> None:
        self.press(" ")
        expect(self.page.locator("#paused")).to_be_visible()

    def scrub(self, frame: int) -> None:
        """Click on the timeline, in the middle of a frame."""
        box = self.page.locator("#lanes").bounding_box()
        across = (frame + 0.5) / self.frames * box["width"]
        self.page.mouse.click(box["x"] + across, box["y"] + box["height"] / 2)
        until(self.page, "at => document.getElementById('seek').value == at", str(frame))

    def point(self, question: str, name: str) -> Locator:
        own = self.page.locator(f'[data-question="{question}"]')
        return own.get_by_role("button", name=name, exact=True)

    def said(self) -> dict[str, str]:
        """Question → what is pressed."""
        own = {name: self.page.locator(f'[data-question="{name}"]') for name in QUESTIONS}
        pressed = {name: box.locator('[aria-pressed="true"]') for name, box in own.items()}
        return {name: one.get_attribute("value") for name, one in pressed.items() if one.count()}

    def writes(self, *answers: tuple[str, int]) -> list[dict]:
        """Wait until these are the answers in the file, by question, in the order of its pairs."""
        end = time.monotonic() + MOST_MS / 1000
        while [(row["question"], int(row["answer"])) for row in self.written()] != [*answers]:
            assert time.monotonic() < end, self.written()
            self.page.wait_for_timeout(POLL_MS)
        return self.written()

    def written(self) -> list[dict]:
        if not self.file.exists():
            return []
        with self.file.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def drawn(rated_once) -> Iterator[Shown]:
    """A pair of each kind, on faces."""
    of_all = study(rated_once, pairs=1)
    faces = rating.Faces(of_all, None)
    yield of_all, faces
    faces.end()


@pytest.fixture(scope="module")
def faces(drawn, tmp_path_factory) -> Iterator[Serving]:
    served = Serving(drawn, tmp_path_factory.mktemp("faces") / "answers.csv")
    yield served
    served.end()


@pytest.fixture(scope="module")
def filmed(rated_once) -> Shown:
    """A pair of each kind but generation, with films."""
    of_films = study(rated_once, pairs=1, kinds=REAL)
    return of_films, rating.Faces(of_films, None)


@pytest.fixture
def films(filmed, tmp_path) -> Iterator[Serving]:
    served = Serving(filmed, tmp_path / "answers.csv")
    yield served
    served.end()


@pytest.fixture
def rate(faces, tabs) -> RatePage:
    return RatePage(faces, tabs).begin()


def test_all_pairs_are_rated_by_key_and_written_with_their_kinds(faces, tabs):
    rate = RatePage(faces, tabs)
    page = rate.page
    expect(page.locator("#intro")).to_contain_text("You will see 4 clips")
    expect(page.locator("#intro")).to_contain_text("The answers are those of ann")
    take_picture(page, "rate_intro")
    page.keyboard.press("Enter")
    given = []
    for number in range(1, 5):
        rate.shows(number)
        expect(page.locator(".question.marked")).to_have_attribute("data-question", "accurate")
        rate.press(str(number), "5")
        given += [("accurate", number), ("natural", 5)]
    expect(page.locator("#done")).to_contain_text("Thank you, ann")
    rows = rate.writes(*given)
    expect(page.locator("#done-what")).to_have_text(
        f"The answers on 4 clips are written to {faces.file}."
    )
    expect(page.locator("#done-command")).to_have_text(f"mimeline ratings {faces.file}")
    take_picture(page, "rate_done")
    assert not [kind for kind in KINDS if kind in page.content()]
    assert {row["kind"] for row in rows} == set(KINDS)
    assert {row["person"] for row in rows} == {"ann"}
    assert all(0 <= float(row["seconds"]) < MOST_MS / 1000 for row in rows)


def test_answers_are_taken_back_one_by_one_and_given_anew(rate):
    rate.press("4", "2")
    rate.shows(2)
    rate.press("1")
    rate.writes(("accurate", 4), ("natural", 2), ("accurate", 1))
    rate.press("u")
    rate.writes(("accurate", 4), ("natural", 2))
    assert rate.said() == {}
    rate.press("Backspace")
    rate.shows(1)
    rate.writes(("accurate", 4))
    assert rate.said() == {"accurate": "4"}
    rate.press("3")
    rate.writes(("accurate", 4), ("natural", 3))
    rate.shows(2)
    rate.press("u", "u")
    rate.shows(1)
    rate.writes()
    expect(rate.page.get_by_role("button", name="Undo")).to_be_disabled()


def test_an_answer_is_changed_by_going_back_also_when_the_page_is_loaded_anew(rate):
    rate.point("accurate", "4 Agree").click()
    rate.point("natural", "3 Don’t know").click()
    rate.shows(2)
    rate.writes(("accurate", 4), ("natural", 3))
    rate.page.reload()  # it goes on where it was
    rate.shows(2)
    rate.press("ArrowLeft")
    rate.shows(1)
    assert rate.said() == {"accurate": "4", "natural": "3"}
    rate.press("ArrowDown", "1")
    rate.writes(("accurate", 4), ("natural", 1))
    rate.shows(2)
    rate.page.get_by_role("button", name="Previous pair").click()
    rate.shows(1)
    assert rate.said() == {"accurate": "4", "natural": "1"}


def test_the_drawn_face_moves_with_the_playhead_and_the_timeline_moves_the_face(rate):
    page = rate.page
    before = page.evaluate(FACE)
    until(page, f"before => {FACE} != before", before)
    rate.stop()
    rate.scrub(10)
    tenth = page.evaluate(FACE)
    assert page.locator("#clock").inner_text() == "0.50 s"
    rate.press(".")
    assert rate.frame == 11
    assert page.evaluate(FACE) != tenth
    rate.press(",")
    assert rate.frame == 10
    assert page.evaluate(FACE) == tenth
    rate.scrub(2)
    assert page.evaluate(FACE) != tenth


def test_the_film_and_the_playhead_show_the_same_frame(films, tabs):
    rate = RatePage(films, tabs).begin()
    page = rate.page
    until(page, "Number(document.getElementById('seek').value) > 3")
    rate.stop()
    for frame in (15, 4, 20):
        rate.scrub(frame)
        until(page, f"shade => Math.abs({SHADE} - shade) < 4", A_FRAME * frame)
    rate.press(",")
    until(page, f"shade => Math.abs({SHADE} - shade) < 4", A_FRAME * 19)
    until(page, "document.getElementById('seek').value == 19")
    take_picture(page, "rate_film")
    box = page.locator("#lanes").bounding_box()
    page.mouse.move(box["x"] + box["width"] * 0.2, box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.6, box["y"] + 60, steps=4)
    page.mouse.up()
    until(page, f"shade => Math.abs({SHADE} - shade) < 4", A_FRAME * 14)


def test_what_is_done_at_the_playhead_is_highlighted_and_told(rate):
    rate.stop()
    bar = rate.page.locator('[data-track="brow"] .act').first
    start = bar.evaluate("e => e.style.left")
    first = round(float(start.removesuffix("%")) / 100 * rate.frames)
    now = rate.page.locator('[data-track="brow"] .now')
    rate.scrub(first)
    expect(now).to_have_text("Brow up")
    expect(bar).to_have_class(re.compile(r"\bon\b"))
    rate.press(",")
    expect(now).to_have_text("neutral")
    expect(bar).not_to_have_class(re.compile(r"\bon\b"))


def test_what_is_not_measured_is_told_of_every_pair_alike(rate):
    for number in range(1, rate.pairs + 1):
        rate.shows(number)
        tracks = rate.page.locator("[data-track]")
        assert [one.get_attribute("data-track") for one in tracks.all()] == [*TRACKS]
        missing = rate.page.locator(".missing")
        expect(missing).to_have_count(1)
        expect(missing).to_have_attribute("data-track", "gaze_v")
        expect(missing.locator(".now")).to_have_text("not measured")
        expect(missing.locator(".act")).to_have_count(0)
        mouth = rate.page.locator('[data-track="mouth"] .name')
        expect(mouth).to_have_attribute("title", "Not measured: mouth frown")
        rate.press("ArrowRight")


def test_nothing_that_the_page_is_told_or_shows_is_a_kind_or_a_clip(faces, tabs):
    rate, answers, shown = RatePage(faces, tabs), [], []
    rate.page.on("response", lambda answer: answers.append(answer))
    rate.page.reload()
    rate.begin()
    for number in range(1, rate.pairs + 1):
        rate.shows(number)
        shown.append(rate.page.content())
        rate.press("4", "ArrowRight")
    clips = {row["clip_id"] for row in rate.writes(*[("accurate", 4)] * rate.pairs)}
    told = [f"{one.url} {one.headers} {one.text()}" for one in answers if "/sheet/" not in one.url]
    assert sum("/pairs/" in one.url for one in answers) == rate.pairs
    for text in [*told, *shown]:
        assert not [word for word in (*KINDS, *clips) if word in text]


def test_answers_wait_while_the_server_is_away(films, filmed, tabs):
    rate = RatePage(films, tabs).begin()
    films.end()
    rate.press("5", "1")
    alarm = rate.page.get_by_role("alert")
    expect(alarm).to_contain_text("Not written yet, 2 answers wait")
    take_picture(rate.page, "rate_away")
    assert rate.written() == []
    again = Serving(filmed, films.file, key="another", port=films.port)
    try:
        tabs.open(again.address)  # its key counts for the other tab as well
        rate.writes(("accurate", 5), ("natural", 1))
        expect(alarm).to_be_hidden()
    finally:
        again.end()
    tabs.expect("Failed to load resource: (net::ERR_|.*403).*")


def test_what_cannot_be_shown_is_passed_over_and_said(films, filmed, tabs):
    rate = RatePage(films, tabs)
    page = rate.page
    page.route("**/media/film/*", lambda route: route.fulfill(status=200, body="no film"))
    page.keyboard.press("Enter")
    without = page.get_by_role("button", name="Go on without it")
    expect(without).to_be_visible()
    take_picture(page, "rate_unseen")
    rate.press("5")
    expect(page.locator("#toast")).to_have_text("There is nothing to be seen")
    without.click()
    expect(page.locator("#place")).to_have_text("2 of 3")
    expect(without).to_be_visible()  # also of one that was asked for ahead
    rate.press("0")
    expect(page.locator("#place")).to_have_text("3 of 3")
    expect(without).to_be_visible()
    page.unroute("**/media/film/*")
    rate.press("ArrowLeft", "ArrowLeft")
    rate.shows(1)
    assert rate.said() == {}
    rate.press("4")  # the other question is open again
    rate.writes(("accurate", 4), ("accurate", 0), ("natural", 0))
    rate.press("2", "n")
    rate.shows(3)
    rate.press("3", "3")
    expect(page.locator("#done-what")).to_contain_text("Of 1 clip there was no picture")
    answers = ("accurate", 4), ("natural", 2), ("accurate", 0), ("natural", 0)
    rate.writes(*answers, ("accurate", 3), ("natural", 3))


def test_a_person_who_wants_no_motion_begins_with_a_still_picture(faces, new_tabs):
    rate = RatePage(faces, new_tabs(reduced_motion="reduce")).begin()
    expect(rate.page.locator("#paused")).to_be_visible()
    assert rate.frame == 0
    rate.press(" ")
    until(rate.page, "document.getElementById('seek').value > 0")


def test_everything_is_in_sight_and_nothing_is_cut_however_wide_the_window(rate):
    page = rate.page
    for width, height in ((1400, 860), (1100, 700), (390, 800)):
        page.set_viewport_size({"width": width, "height": height})
        until(page, f"innerWidth == {width} && document.documentElement.scrollWidth <= {width}")
        take_picture(page, f"rate_{width}")
        deep = page.evaluate("document.documentElement.scrollHeight")
        assert width < 860 or deep <= height
        for box in page.evaluate(BOXES):
            assert box["left"] >= 0 and box["right"] <= width, box
            assert box["top"] >= 0 and box["bottom"] <= deep, box
        assert page.evaluate(CUT) == []

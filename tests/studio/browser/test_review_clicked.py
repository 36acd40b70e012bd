"""The review page, clicked through: what a person decides is on disk and comes back."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from mimeline.clips.exclusions import read_exclusions

from .served import Served
from .tabs import take_picture, until

HOSTILE = '<img src=x onerror="document.title=1">'


@pytest.fixture(scope="module")
def served(serve, filmed, tmp_path_factory) -> Served:
    file = tmp_path_factory.mktemp("list") / "out.csv"
    return serve("review", "--results", filmed, "--exclusions", file=file)


@pytest.fixture
def exclusions(served) -> Path:
    """The list that is written; not begun yet."""
    for file in served.file.parent.iterdir():
        file.unlink()
    return served.file


@pytest.fixture
def page(served, exclusions, tabs) -> Page:
    page = tabs.open(served.address)
    shows(page, "-a_1")
    return page


def shows(page: Page, clip_id: str) -> None:
    expect(page.locator("#clip-id")).to_have_text(clip_id)


def on_disk(page: Page, holds: str) -> None:
    """Wait until something holds of the decisions that the server has written."""
    until(page, f"fetch('/decisions').then((answer) => answer.json()).then((told) => {holds})")


def decided(page: Page, clip_id: str, told: str) -> None:
    expect(page.locator("#rows button", has_text=clip_id)).to_have_accessible_name(
        f"{clip_id}, {told}"
    )


def test_clips_are_kept_left_out_and_taken_back_by_key(page, exclusions):
    page.keyboard.press("k")
    shows(page, "b_1")
    page.keyboard.press("2")
    decided(page, "b_1", "left out: wrong crop")
    decided(page, "-a_1", "kept")
    on_disk(page, "told.seen.length == 2")
    assert read_exclusions(exclusions) == {"b_1": "wrong_crop"}
    take_picture(page, "review")
    page.keyboard.press("u")
    decided(page, "b_1", "not looked at")
    page.keyboard.press("u")
    decided(page, "-a_1", "not looked at")
    expect(page.get_by_role("button", name="Undo")).to_be_disabled()
    on_disk(page, "!told.seen.length")
    assert read_exclusions(exclusions) == {}


def test_another_reason_is_typed_and_shown_as_text(page, exclusions):
    page.get_by_role("button", name="other …").click()
    page.get_by_role("combobox", name="Why leave it out?").fill(HOSTILE)
    page.keyboard.press("Enter")
    shows(page, "b_1")
    page.keyboard.press("ArrowLeft")
    expect(page.locator("#verdict")).to_have_text(f"left out: {HOSTILE.replace('_', ' ')}")
    expect(page.locator("#texts")).to_contain_text("<img src=x onerror=")  # of the catalogue
    assert page.locator("img").count() == 0
    assert page.title() == "-a_1 · Review"
    on_disk(page, "told.reasons['-a_1']")
    assert read_exclusions(exclusions) == {"-a_1": HOSTILE}


def test_a_decision_holds_when_the_page_is_loaded_anew_and_can_still_be_taken_back(page):
    page.keyboard.press("1")
    shows(page, "b_1")
    on_disk(page, "told.seen.length == 1")
    page.reload()
    shows(page, "b_1")
    decided(page, "-a_1", "left out: occlusion")
    page.keyboard.press("u")
    shows(page, "-a_1")
    decided(page, "-a_1", "not looked at")


def test_two_tabs_do_not_undo_each_other(page, tabs, served, exclusions):
    other = tabs.open(served.address)
    shows(other, "-a_1")
    page.keyboard.press("3")
    decided(page, "-a_1", "left out: low quality")
    on_disk(page, "told.seen.length == 1")
    other.keyboard.press("k")  # it has not heard yet
    expect(other.locator("#toast")).to_contain_text("decided on elsewhere meanwhile")
    decided(other, "-a_1", "left out: low quality")
    assert read_exclusions(exclusions) == {"-a_1": "low_quality"}
    tabs.expect("Failed to load resource: .*409 .*")


def test_a_film_plays_stops_and_goes_by_frames(page):
    film = "document.querySelector('#film video:not([hidden])')"
    until(page, f"{film}.currentTime > 0.2 && {film}.videoWidth == 64")
    page.keyboard.press(" ")
    expect(page.locator("#paused")).to_be_visible()
    at = page.evaluate(f"{film}.currentTime")
    page.keyboard.press(",")
    until(page, f"at => {film}.currentTime < at", at)
    page.keyboard.press("ArrowRight")
    shows(page, "b_1")
    until(page, f"!{film}.paused && {film}.currentTime > 0")


def test_what_was_done_is_told_in_the_terminal_at_the_end(serve, filmed, tabs, tmp_path):
    served = serve("review", "--results", filmed, "--exclusions", file=tmp_path / "out.csv")
    page = tabs.open(served.address)
    shows(page, "-a_1")
    page.keyboard.press("1")
    page.keyboard.press("k")
    decided(page, "b_1", "kept")
    on_disk(page, "told.seen.length == 2")
    page.close()
    assert "2 clips looked at, 1 left out." in served.end()

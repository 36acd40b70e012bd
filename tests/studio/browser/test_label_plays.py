"""What the label page shows of a cluster: exemplars that play, in step with their curves."""

import pytest
from playwright.sync_api import expect

from .label_page import LabelPage, first_exemplar
from .served import Served
from .tabs import take_picture, until

PICTURE = "document.querySelector('#cards figure:nth-child({}) .picture canvas').toDataURL()"


@pytest.fixture(scope="module")
def served(serve, drawn_once, tmp_path_factory) -> Served:
    file = tmp_path_factory.mktemp("names") / "names.yaml"
    return serve("label", "--results", drawn_once, "--file", file=file)


@pytest.fixture
def label(label, drawn_once) -> LabelPage:
    label.open("brow/0")
    told = first_exemplar(drawn_once, "brow/0")
    expect(label.cards.first).to_have_attribute("title", told)
    for card in label.cards.all():
        expect(card.locator(".none")).to_be_hidden()  # its picture has come
    return label


def test_exemplars_play_stop_and_go_by_frames_together(label):
    cards = range(1, label.cards.count() + 1)
    for card in cards:
        picture = PICTURE.format(card)
        before = label.page.evaluate(picture)
        until(label.page, f"before => {picture} != before", before)
    take_picture(label.page, "label_plays")
    label.press(" ")
    expect(label.page.locator("#paused")).to_be_visible()
    still = [label.page.evaluate(PICTURE.format(card)) for card in cards]
    label.page.evaluate("new Promise(requestAnimationFrame)")
    assert still == [label.page.evaluate(PICTURE.format(card)) for card in cards]
    label.press(*"....")  # of a long one, not every frame has a picture
    for card, before in zip(cards, still, strict=True):
        until(label.page, f"before => {PICTURE.format(card)} != before", before)


def test_v_changes_between_the_film_and_the_drawn_face(label, tabs):
    view = label.page.locator("#view")
    expect(view).to_have_text("Film")
    label.press(" ")
    filmed = label.page.locator("#cards figure").count()
    pictures = [PICTURE.format(card) for card in range(1, filmed + 1)]
    film = [label.page.evaluate(picture) for picture in pictures]
    label.press("v")
    expect(view).to_have_text("Drawn face")
    until(label.page, f"film => {pictures[0]} != film", film[0])
    take_picture(label.page, "label_face")
    asked = [url for url in tabs.requested if "/pictures/" in url]
    assert any("/pictures/film/brow/0/" in url for url in asked)
    assert any("/pictures/face/brow/0/" in url for url in asked)
    label.press("v")
    until(label.page, f"film => {pictures[0]} == film", film[0])


def test_curves_of_every_channel_are_drawn(label):
    drawn = """[...document.querySelectorAll('#cards .curves canvas')].map((canvas) => {
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        const colours = new Set();
        for (let at = 0; at < data.length; at += 4)
            if (data[at + 3] == 255) colours.add(`${data[at]} ${data[at + 1]} ${data[at + 2]}`);
        return colours.size;
    })"""
    channels = label.page.locator("#legend > span").count()
    assert channels >= 2
    colours = label.page.evaluate(drawn)
    assert len(colours) == label.cards.count()
    assert min(colours) >= channels


@pytest.mark.parametrize(("width", "height"), [(1100, 700), (1400, 860)])
def test_everything_is_in_sight(label, width, height):
    label.page.set_viewport_size({"width": width, "height": height})
    until(label.page, f"innerWidth == {width} && document.documentElement.scrollWidth <= {width}")
    take_picture(label.page, f"label_{width}")
    for button in label.page.locator("#name button, header button").all():
        box = button.bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= width
        assert box["y"] >= 0 and box["y"] + box["height"] <= height
    for text in label.page.locator("#name button span, header button").all():
        assert text.evaluate("e => e.scrollWidth <= e.clientWidth + 1 || !e.clientWidth")

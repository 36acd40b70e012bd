"""A second person on the label page: blind, and compared with the first."""

from playwright.sync_api import Page, expect

from mimeline.annotation.label_file import Answer

from .label_page import LabelPage
from .tabs import take_picture, until

KEYS = {"brow/0": "1", "brow/1": "0", "brow/3": "2", "eye/1": "2"}  # of the first person
UP, DOWN, WIDEN = Answer("BrowUp"), Answer("BrowDown"), Answer("EyeWiden")


def name(label: LabelPage, keys: dict[str, str]) -> None:
    for cluster, key in keys.items():
        label.open(cluster)
        label.press(key)


def second_person(page: Page, person: str) -> None:
    page.keyboard.press("p")
    page.get_by_role("dialog").get_by_role("textbox").fill(person)
    page.keyboard.press("Enter")
    expect(page.locator("#who")).to_have_text(f"{person} answers, blind")


def test_a_second_person_is_blind_until_they_answered(label):
    label.open("brow/0")
    label.press("1")
    label.writes("brow/0", UP)
    second_person(label.page, "bo")
    expect(label.page.locator("#progress")).to_contain_text("0 of 13 named")
    clusters = label.page.evaluate(
        """fetch('/state?person=bo').then((answer) => answer.json()).then(
            (told) => told.regions.flatMap((region) => region.clusters))"""
    )
    assert len(clusters) == 13
    for told in clusters:
        hidden = ("proposed", "answer", "agreement", "purity")
        assert [told[key] for key in hidden] == [None] * len(hidden)
    label.open("brow/0")
    expect(label.page.locator("#state")).to_have_text("No name yet")
    take_picture(label.page, "label_blind")
    label.press("2")
    own = label.file.with_name("names.bo.yaml")
    label.writes("brow/0", DOWN, own)
    assert label.written() == {"brow/0": UP}
    label.page.reload()
    expect(label.page.locator("#who")).to_have_text("bo answers, blind")  # it stays theirs
    expect(label.row("brow/0")).to_contain_text("Brow down")


def test_two_persons_are_compared_and_where_they_differ_is_a_click_away(label):
    name(label, KEYS)
    label.writes("eye/1", WIDEN)
    second_person(label.page, "bo")
    own = label.file.with_name("names.bo.yaml")
    name(label, KEYS | {"brow/3": "0"})
    label.writes("eye/1", WIDEN, own)
    label.press("p")
    agreement = label.page.locator("#agreement")
    expect(agreement).to_contain_text("The first person and bo")
    # (po - pe) / (1 - pe) of 3 of 4 alike, pe = (2·1 + 1·1 + 0·1 + 1·1) / 16 of the four names
    expect(agreement).to_contain_text("kappa 0.67, substantial, over 4 clusters")
    expect(agreement).to_contain_text("1 differ")
    take_picture(label.page, "label_agreement")
    agreement.get_by_role("button", name="brow 3").click()
    label.shows("brow/3")
    expect(label.page.locator("#state")).to_have_text("Neutral")
    label.press("p")
    label.page.get_by_role("button", name="Back to the first person").click()
    expect(label.row("brow/3")).to_contain_text("Brow down")
    label.press("u")  # the first person's last answer, not the second's
    label.writes("eye/1", None)
    assert label.written(own)["eye/1"] == WIDEN


def test_a_page_started_for_a_person_is_theirs_and_blind_from_its_first_request(
    serve, tabs, labelled_once, tmp_path
):
    first = tmp_path / "names.yaml"
    own = first.with_name("names.bo.yaml")
    words = ("label", "--results", labelled_once)
    served = serve(*words, "--person", "bo", "--file", file=first)
    label = LabelPage(tabs.open(served.address), first)
    who = label.page.locator("#who")
    expect(who).to_have_text("bo answers, blind")
    asked = [url for url in tabs.requested if "/state" in url]
    assert asked and all(url.endswith("person=bo") for url in asked)
    expect(label.page.locator("#help-file")).to_have_text(str(own))
    label.press("p")
    expect(label.page.locator("#person")).to_be_visible()
    expect(label.page.get_by_role("button", name="Back to the first person")).to_have_count(0)
    label.press("Escape")
    rows = label.row().count()
    for _ in range(rows):
        shown = label.shown
        label.press("0")
        expect(label.row(shown)).to_have_attribute("aria-current", "false")
    done = label.page.locator("#done")
    expect(done.locator("#done-file")).to_have_text(str(own))
    expect(done).to_contain_text("The first person has named none of these clusters yet")
    expect(done.get_by_role("button", name="Second person")).to_be_hidden()
    until(label.page, "location.hash == ''")
    take_picture(label.page, "label_done_second")
    label.writes(shown, Answer("Neutral"), own)
    assert not first.exists()


def test_the_same_tab_begins_anew_as_whom_the_page_was_started_for(
    serve, tabs, labelled_once, tmp_path
):
    words = ("label", "--results", labelled_once)
    file = tmp_path / "names.yaml"
    served = serve(*words, "--person", "bo", "--file", file=file)
    label = LabelPage(tabs.open(served.address), file)
    second_person(label.page, "cy")
    label.page.goto("about:blank")
    served.end()
    again = serve(*words, "--person", "di", "--file", file=file, port=served.port)
    label.page.goto(again.address)
    expect(label.page.locator("#who")).to_have_text("di answers, blind")

"""The label page, clicked through by one person: each answer is on disk at once."""

from playwright.sync_api import expect

from mimeline import tables
from mimeline.annotation.label_file import Answer, read_label_file

from .label_page import LabelPage, first_exemplar
from .labelled_run import HOSTILE
from .tabs import take_picture

UP, NEUTRAL, NOT_SURE = Answer("BrowUp"), Answer("Neutral"), Answer()


def test_a_key_names_a_cluster_and_undo_takes_it_back(label):
    label.open("brow/0")
    undo = label.page.get_by_role("button", name="Undo")
    expect(undo).to_be_disabled()
    label.press("1")
    label.writes("brow/0", UP)
    expect(label.row("brow/0")).to_have_accessible_name(
        r"brow, cluster 0: named: Brow up, 13 % of frames"
    )
    assert label.shown != "brow/0"  # it goes on by itself
    label.press("u")
    label.writes("brow/0", None)
    label.shows("brow/0")
    expect(undo).to_be_disabled()
    label.press("0")
    label.writes("brow/0", NEUTRAL)
    expect(label.page.locator("#progress")).to_contain_text("1 of 13 named")


def test_a_finer_name_is_picked_or_typed_and_is_text(label):
    label.open("brow/0")
    label.press("1", "f", "1")
    label.writes("brow/0", Answer("BrowUp", "strong"))
    label.open("brow/2")
    label.press("1", "f")
    note = label.page.get_by_role("dialog").get_by_role("textbox")
    note.fill(HOSTILE)
    label.press("Enter")
    label.writes("brow/2", Answer("BrowUp", HOSTILE))
    expect(label.row("brow/2")).to_contain_text(HOSTILE)
    label.open("brow/2")
    expect(label.page.locator("#state")).to_have_text(f"Brow up, {HOSTILE}")
    take_picture(label.page, "label_finer")
    label.press("u", "u", "u")
    label.writes("brow/0", UP)
    assert set(label.written()) == {"brow/0"}
    assert label.page.locator("img").count() == 0
    assert label.page.title() != "1"


def test_a_cluster_is_merged_into_another_and_bears_its_name(label):
    label.open("mouth/1")
    label.press("3")
    label.writes("mouth/1", Answer("MouthFrown"))
    label.open("mouth/4")
    label.press("m")
    candidate = label.page.locator('[data-into="1"]')
    expect(candidate).to_contain_text("Mouth frown")
    take_picture(label.page, "label_merge")
    candidate.click()
    label.writes("mouth/4", Answer(same_as=1))
    expect(label.row("mouth/4")).to_contain_text("same as 1")
    label.open("mouth/4")
    expect(label.page.locator("#state")).to_have_text("same as 1 (Mouth frown)")
    label.press("u")
    label.writes("mouth/4", None)
    label.press("m", "1")  # by its number, as well
    label.writes("mouth/4", Answer(same_as=1))


def test_who_is_not_sure_is_shown_more_and_may_leave_it_so(label, labelled_once):
    table = tables.read(tables.EXEMPLARS, labelled_once / "label" / "exemplars.parquet")
    own = table[(table["region"] == "brow") & (table["cluster"] == 1)].sort_values("rank")
    assert (own["kind"] == "further").any()
    label.open("brow/1")
    told = first_exemplar(labelled_once, "brow/1")
    expect(label.cards.first).to_have_attribute("title", told)
    first = int((own["kind"] != "further").sum())
    expect(label.cards).to_have_count(first)
    while (before := label.cards.count()) < len(own):
        label.press("x")
        expect(label.cards.nth(before)).to_be_visible()
        assert label.written() == {}
    expect(label.cards).to_have_count(len(own))
    take_picture(label.page, "label_not_sure")
    label.press("x")
    label.writes("brow/1", NOT_SURE)
    expect(label.row("brow/1")).to_have_accessible_name(
        r"brow, cluster 1: not sure, 47 % of frames"
    )
    looked = read_label_file(label.file)["brow"].shown[1]
    intervals = own[["clip_id", "start_frame", "end_frame"]].itertuples(index=False, name=None)
    assert list(looked) == list(intervals)


def test_all_is_named_by_the_keyboard_alone_and_the_end_tells_what_to_type(
    serve, tabs, labelled_once, tmp_path
):
    served = serve("label", "--results", labelled_once, "--file", file=tmp_path / "names.yaml")
    label = LabelPage(tabs.open(served.address), served.file)
    proposed = tables.read(tables.LABELS, labelled_once / "label" / "proposed.parquet")
    seen = set()
    while len(seen) < len(proposed):
        shown = label.shown
        seen.add(shown)
        label.press("Enter")  # at once, whether or not its pictures came
        expect(label.row(shown)).to_have_attribute("aria-current", "false")
    expect(label.page.locator("#done")).to_be_visible()
    take_picture(label.page, "label_done")
    command = label.page.locator("#done-command").inner_text()
    assert f"label={{file: {label.file}}}" in command
    expected = {f"{r.region}/{r.cluster}": Answer(r.action) for r in proposed.itertuples()}
    assert seen == set(expected)
    label.writes(shown, expected[shown])
    assert label.written() == expected
    label.page.close()
    said = served.end()
    assert "13 of 13 clusters are named: brow 4 of 4, eye 4 of 4 and mouth 5 of 5" in said
    assert command in said


def test_arrows_walk_the_list_and_stop_at_its_ends(label):
    rows = [row.get_attribute("data-cluster") for row in label.row().all()]
    label.open(rows[0])
    label.press("ArrowUp")
    label.shows(rows[0])
    for key, row in (("ArrowDown", rows[1]), ("ArrowRight", rows[2]), ("ArrowLeft", rows[1])):
        label.press(key)
        label.shows(row)
    assert label.written() == {}
    label.press("?")
    expect(label.page.get_by_role("dialog", name="Keys")).to_be_visible()
    label.press("1", "Enter")  # no name while it is open
    assert label.written() == {}


def test_the_page_goes_on_where_it_was_when_it_is_loaded_anew(label):
    label.open("eye/2")
    label.press("1")
    label.writes("eye/2", Answer("EyeSquint"))
    shown = label.shown
    label.page.reload()
    label.shows(shown)
    expect(label.row("eye/2")).to_contain_text("Eye squint")
    label.press("u")
    label.writes("eye/2", None)
    label.shows("eye/2")


def test_two_tabs_do_not_overwrite_each_other(label, tabs, served):
    other = LabelPage(tabs.open(served.address), label.file)
    for tab in (label, other):
        tab.open("brow/3")
    label.press("2")
    label.writes("brow/3", Answer("BrowDown"))
    other.press("1")  # it has not heard yet
    other.says("answered elsewhere meanwhile, Brow down")
    expect(other.row("brow/3")).to_contain_text("Brow down")
    other.open("brow/1")
    other.press("0")
    other.writes("brow/1", NEUTRAL)
    assert label.written() == {"brow/3": Answer("BrowDown"), "brow/1": NEUTRAL}
    tabs.expect("Failed to load resource: .*409 .*")


def test_what_is_told_anew_while_exemplars_come_does_not_hold_them_up(label, tabs, served):
    other = LabelPage(tabs.open(served.address), label.file)
    held = []
    label.page.route("**/exemplars/mouth/4*", lambda route: held.append(route))
    label.row("mouth/4").click()
    expect(label.cards).to_have_count(0)
    other.open("brow/3")
    other.press("1")
    other.writes("brow/3", UP)
    label.page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    expect(label.row("brow/3")).to_contain_text("Brow up")
    held[0].continue_()
    expect(label.cards.first).to_be_visible()


def test_a_cluster_keeps_its_cards_when_one_that_is_slow_was_left_for_it(label):
    label.open("brow/3")
    expect(label.cards.first).to_be_visible()
    label.page.route("**/exemplars/mouth/4*", lambda route: None)
    label.page.evaluate(
        """keys => {
            for (const key of keys) document.querySelector(`[data-cluster="${key}"]`).click();
            return new Promise((done) => setTimeout(done, 400));
        }""",
        ["mouth/4", "brow/3"],
    )
    label.shows("brow/3")
    expect(label.cards.first).to_be_visible()


def test_a_finer_name_does_not_overwrite_what_was_said_elsewhere_meanwhile(label, tabs, served):
    label.open("brow/3")
    label.press("1")
    label.writes("brow/3", UP)
    label.press("f")
    expect(label.page.locator("dialog[open]")).to_be_visible()
    other = LabelPage(tabs.open(served.address), label.file)
    other.open("brow/3")
    other.press("0")
    other.writes("brow/3", NEUTRAL)
    label.page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    expect(label.row("brow/3")).to_contain_text("Neutral")
    label.page.bring_to_front()
    label.page.keyboard.type("strong")
    label.press("Enter")
    label.says("answered elsewhere meanwhile")
    assert label.written() == {"brow/3": NEUTRAL}


def test_what_is_answered_while_the_server_is_away_is_written_when_it_is_back(
    serve, tabs, labelled_once, tmp_path
):
    words = ("label", "--results", labelled_once, "--file")
    served = serve(*words, file=tmp_path / "names.yaml")
    label = LabelPage(tabs.open(served.address), served.file)
    label.open("brow/0")
    served.kill()
    label.press("1")
    expect(label.page.get_by_role("alert")).to_contain_text("Not written yet, 1 answer waits")
    take_picture(label.page, "label_away")
    assert label.written() == {}
    again = serve(*words, file=served.file, port=served.port)
    tabs.open(again.address)  # its key counts for the other tab as well
    label.writes("brow/0", UP)
    expect(label.page.get_by_role("alert")).to_be_hidden()
    tabs.expect("Failed to load resource: (net::ERR_|.*403).*")


def test_a_clip_with_a_hostile_name_is_text(label, labelled_once):
    table = tables.read(tables.EXEMPLARS, labelled_once / "label" / "exemplars.parquet")
    own = table[(table["clip_id"] == HOSTILE) & (table["kind"] != "further")].iloc[0]
    label.open(f"{own['region']}/{own['cluster']}")
    card = label.cards.filter(has_text=HOSTILE).first
    expect(card).to_be_visible()
    assert label.page.title() != "1"
    assert label.page.locator("#cards img").count() == 0

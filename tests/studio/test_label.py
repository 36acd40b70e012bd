import json
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Thread
from urllib.parse import quote

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.annotation.label_file import Answer, kept_copy, read_label_file
from mimeline.errors import BadConfig, BadFile, BadLabels, NoSuchFile
from mimeline.studio.answers import MOST_CHARACTERS
from mimeline.studio.clusters_of_run import MOST_PICTURES, ClustersOfRun
from mimeline.studio.label import PAUSE_S, Stopwatch, closing, own_file, serve
from mimeline.studio.pictures import COLUMNS, EDGE, Pictures
from mimeline.studio.server import MOST_BYTES

from .fitted_run import FITS, FRAMES, HOSTILE, refit, said

BROW = ("brow", 0)
MOVED = "d" * 16  # another fit


# --- what is told -------------------------------------------------------------------------------


def test_the_state_tells_regions_clusters_and_what_to_look_at_next(label_page):
    state = label_page().state()
    brow, eye, mouth = state["regions"]
    assert (brow["name"], eye["name"], mouth["name"]) == ("brow", "eye", "mouth")
    assert eye["clusters"] == [] and eye["reason"].startswith("not measured")
    assert brow["reason"] == "" and len(brow["channels"]) > len(brow["left_out"]) == 1
    assert mouth["unmeasured"] == ["MouthFrown"]
    assert [(a["name"], a["key"], a["words"]) for a in brow["actions"]] == [
        ("BrowUp", "1", "Brow up"),
        ("BrowDown", "2", "Brow down"),
        ("Neutral", "0", "Neutral"),
    ]
    cluster = brow["clusters"][0]
    assert cluster["proposed"] == {"action": "BrowUp", "confidence": 0.6, "why": ""}
    assert (cluster["n_frames"], cluster["median_s"], cluster["nearest"]) == (40, 0.5, 1)
    assert cluster["answer"] is None and cluster["n_exemplars"] == 3 and cluster["n_shown"] == 0
    assert brow["clusters"][3]["proposed"]["why"] == "nothing is known of it"
    assert state["persons"] == [""] and "--until annotate" in state["command"]
    worth = {(r["name"], c["number"]): c["worth"] for r in (brow, mouth) for c in r["clusters"]}
    assert sorted(map(tuple, state["next"])) == sorted(worth)
    ahead = [worth[region, cluster] for region, cluster in state["next"]]
    assert ahead == sorted(ahead, reverse=True)


def test_an_exemplar_has_its_curves_with_what_is_before_and_after(label_page):
    first, second, third = label_page().get("/exemplars/brow/1").json["exemplars"]
    assert [e["kind"] for e in (first, second, third)] == ["medoid", "random", "further"]
    assert first["from"] < first["start"] < first["end"] < first["to"] <= FRAMES
    assert (first["clip_id"], first["views"], second["views"]) == (
        HOSTILE,
        ["face"],
        ["film", "face"],
    )
    assert first["seconds"] == 0.5 and first["fps"] == 20
    for curve in first["curves"].values():
        assert len(curve) == first["to"] - first["from"]
        gap = 12 - first["from"]  # was not measured
        assert curve[gap] is None and None not in curve[:gap] + curve[gap + 1 :]
        assert curve[gap + 1] == pytest.approx(0.5 + 0.5 * np.sin(13 / 6), abs=1e-3)
    frames = first["sheet"]["frames"]
    assert frames == list(range(first["from"], first["to"])) and len(frames) <= MOST_PICTURES


def test_a_filmed_sheet_shows_each_frame_in_its_place(label_page):
    page = label_page()
    exemplar = page.get("/exemplars/brow/1").json["exemplars"][1]
    answer = page.get("/pictures/film/brow/1/1")
    assert answer.mimetype == "image/jpeg"
    sheet = cv2.imdecode(np.frombuffer(answer.data, np.uint8), cv2.IMREAD_COLOR)
    assert sheet.shape[1] == COLUMNS * EDGE and sheet.shape[0] % EDGE == 0
    for place, frame in enumerate(exemplar["sheet"]["frames"]):
        row, column = divmod(place, COLUMNS)
        middle = sheet[EDGE * row + EDGE // 2, EDGE * column + EDGE // 2]
        assert np.abs(middle.astype(int) - 3 * frame).max() < 6


def test_a_drawn_sheet_leaves_the_place_of_an_unmeasured_frame_empty(label_page):
    page = label_page()
    exemplar = page.get("/exemplars/mouth/0").json["exemplars"][0]
    answer = page.get("/pictures/face/mouth/0/0")
    sheet = cv2.imdecode(np.frombuffer(answer.data, np.uint8), cv2.IMREAD_COLOR)
    frames = exemplar["sheet"]["frames"]
    spread = [
        sheet[EDGE * r : EDGE * (r + 1), EDGE * c : EDGE * (c + 1)].std()
        for r, c in (divmod(place, COLUMNS) for place in range(len(frames)))
    ]
    assert [frame for frame, s in zip(frames, spread, strict=True) if s < 5] == [12]


@pytest.mark.parametrize(
    "path",
    [
        "/pictures/film/brow/1/0",  # no film of that clip
        "/pictures/film/brow/1/9",
        "/pictures/film/brow/-1/0",
        "/pictures/film/eye/0/0",
        "/pictures/other/brow/1/1",
        "/pictures/film/..%2F..%2Fbrow/1/1",
        "/pictures/film/brow/1/..%2F1",
        "/exemplars/brow/9",
        "/exemplars/eye/0",
        "/exemplars/nose/0",
        "/exemplars/brow/%3Cb%3E",
    ],
)
def test_what_is_not_there_is_not_found(label_page, path):
    assert label_page().get(path).status_code == 404


def test_a_film_that_cannot_be_read_is_no_picture_and_the_face_still_is(label_page, fitted):
    (fitted / "fetch" / "00" / "media" / "film_1.mp4").write_bytes(b"no film")
    page = label_page(fitted)
    assert page.get("/pictures/film/brow/1/1").status_code == 404
    assert page.get("/pictures/face/brow/1/1").status_code == 200


def test_long_exemplars_show_every_second_frame_or_third(fitted_once):
    exemplar = next(ClustersOfRun(fitted_once).exemplars())
    for length, step in ((MOST_PICTURES, 1), (MOST_PICTURES + 1, 2), (3 * MOST_PICTURES, 3)):
        longer = type(exemplar)(**vars(exemplar) | {"first": 5, "stop": 5 + length})
        assert longer.frames == list(range(5, 5 + length, step))


def test_sheets_are_kept_while_there_is_room(fitted_once):
    run = ClustersOfRun(fitted_once)
    pictures = Pictures(run, None, most_bytes=1)
    first = pictures.sheet("film", "brow", 1, 1)
    assert pictures.sheet("film", "brow", 2, 1) != first
    assert pictures.sheet("film", "brow", 1, 1) == first
    assert not pictures.is_made(("film", "brow", 2, 1))


def test_when_it_ends_no_sheet_is_being_made_and_none_will_be(fitted_once):
    run = ClustersOfRun(fitted_once)
    pictures, keys = Pictures(run, None), []
    for exemplars in run.regions["brow"].exemplars.values():
        keys += [(view, e.region, e.cluster, e.rank) for e in exemplars for view in e.views]
    pictures.expect(run.exemplars())
    asked = [Thread(target=pictures.sheet, args=key, daemon=True) for key in keys]
    for thread in asked:
        thread.start()
    pictures.end()
    made = [key for key in keys if pictures.is_made(key)]
    for thread in asked:
        thread.join(0.02)
    assert [key for key in keys if pictures.is_made(key)] == made and len(made) < len(keys)


def test_sheets_are_made_before_they_are_asked_for(fitted_once):
    run = ClustersOfRun(fitted_once)
    pictures, exemplars = Pictures(run, None), run.regions["brow"].exemplars[1]
    pictures.expect(exemplars)
    keys = [(view, "brow", 1, e.rank) for e in exemplars for view in e.views]
    until = time.monotonic() + 60
    while not all(map(pictures.is_made, keys)) and time.monotonic() < until:
        time.sleep(0.01)
    assert len(keys) == 4 and all(map(pictures.is_made, keys))


# --- answers ------------------------------------------------------------------------------------


def test_an_answer_is_on_disk_when_the_post_returns_with_what_was_shown(label_page):
    page = label_page()
    answer = page.answer(BROW, ("BrowUp", "strong"), shown=[0, 1])
    assert answer.status_code == 200 and answer.json["now"] == said(("BrowUp", "strong"))
    assert ["brow", 0] not in answer.json["next"] and len(answer.json["next"]) == 6
    written = page.written()["brow"]
    assert written.model == FITS["brow"] and written.clusters == {0: Answer("BrowUp", "strong")}
    assert written.shown == {0: ((HOSTILE, 0, 10), ("film_1", 0, 10))}
    assert page.cluster(*BROW)["answer"] == said(("BrowUp", "strong"))
    page.answer(BROW, "BrowDown", was=("BrowUp", "strong"), shown=[1, 2])
    assert len(page.written()["brow"].shown[0]) == 3 and page.cluster(*BROW)["n_shown"] == 3
    assert page.answer(BROW, None, was="BrowDown").json["now"] is None
    assert page.written()["brow"].clusters == {} and ["brow", 0] in page.state()["next"]


def test_another_start_of_the_command_goes_on_where_the_last_was_killed(label_page):
    label_page().answer(BROW, "BrowUp")
    label_page().answer(("mouth", 2), "not sure")
    page = label_page()
    assert page.cluster(*BROW)["answer"] == said("BrowUp")
    assert page.cluster("mouth", 2)["answer"] == said("not sure")
    assert len(page.state()["next"]) == 5


def test_of_two_writers_each_keeps_what_the_other_wrote(label_page):
    here, there = label_page(), label_page()
    known = here.get("/answers").json["revision"]
    assert there.answer(BROW, "BrowUp").status_code == 200
    assert here.answer(("brow", 1), "BrowDown").status_code == 200
    refused = here.answer(BROW, "Neutral")
    assert refused.status_code == 409 and refused.json == {"holds": said("BrowUp")}
    assert here.answer(BROW, "BrowUp").status_code == 200  # both say the same
    assert here.written()["brow"].clusters == {0: Answer("BrowUp"), 1: Answer("BrowDown")}
    told = there.get(f"/answers?known={known}").json
    assert told["answers"]["brow"] == {"0": said("BrowUp"), "1": said("BrowDown")}
    assert there.get(f"/answers?known={told['revision']}").json == {"revision": told["revision"]}


def test_of_two_pages_that_write_at_once_neither_loses_an_answer(label_page):
    pages = {number: label_page() for number in range(3)}  # which share the file alone

    def answer_often(number: int) -> list[int]:
        was, codes = None, []
        for name in ["BrowUp", "Neutral"] * 10:
            codes.append(pages[number].answer(("brow", number), name, was=was).status_code)
            was = name
        return codes

    with ThreadPoolExecutor(len(pages)) as threads:
        codes = list(threads.map(answer_often, pages))
    assert codes == [[200] * 20] * 3  # 409 where what one had said was gone
    assert label_page().written()["brow"].clusters == dict.fromkeys(pages, Answer("Neutral"))
    assert [path.name for path in pages[0].file.parent.iterdir()] == ["names.yaml"]


def test_comments_at_the_top_of_a_file_stay_and_a_copy_has_the_others(label_page, names):
    names.parent.mkdir()
    text = "# Bo's, of May\n\nbrow:\n  model: " + FITS["brow"]
    text += "\n  clusters:\n    0: BrowUp  # a raise, #1\n    1: {action: BrowUp, note: 'no #'}\n"
    names.write_text(text)
    page = label_page()
    assert page.answer(("brow", 2), "Neutral").status_code == 200
    copy = names.with_name("names.yaml.bak")
    assert names.read_text().startswith("# Bo's, of May\n\nbrow:") and copy.read_text() == text
    assert page.written()["brow"].clusters[1] == Answer("BrowUp", "no #")
    assert f"{copy} has the others" in closing(page.labelling, "", 0.0)
    assert page.answer(("brow", 3), "Neutral").status_code == 200
    again = label_page()
    assert again.answer(("brow", 3), "BrowUp", was="Neutral").status_code == 200
    assert copy.read_text() == text and "has the others" not in closing(again.labelling, "", 0.0)


@pytest.mark.parametrize("there", [True, False])
def test_a_label_file_that_is_a_link_stays_one(label_page, names, tmp_path, there):
    meant = tmp_path / "elsewhere" / "mine.yaml"
    names.parent.mkdir()
    names.symlink_to(meant)
    if there:
        meant.parent.mkdir()
        meant.write_text(f"mouth:\n  model: {FITS['mouth']}\n  clusters:\n    0: Smile\n")
    page = label_page()
    assert page.answer(BROW, "BrowUp").status_code == 200
    assert names.is_symlink() and ("mouth" in read_label_file(meant)) == there
    assert label_page().cluster(*BROW)["answer"] == said("BrowUp")


def test_what_an_editor_writes_meanwhile_is_kept_and_may_be_undone_back(label_page):
    page, odd = label_page(), "odd, " * 20
    page.answer(BROW, "BrowUp")
    text = page.file.read_text()
    page.file.write_text(text.replace("0: BrowUp", f"0: {{action: BrowUp, note: '{odd}'}}"))
    assert page.answer(("brow", 1), "Neutral").status_code == 200
    assert page.written()["brow"].clusters[0].note == odd
    assert page.answer(BROW, "BrowDown", was=("BrowUp", odd)).status_code == 200
    assert page.answer(BROW, ("BrowUp", odd), was="BrowDown").status_code == 200


def test_a_merger_goes_to_the_root_and_follows_it(label_page):
    page = label_page()
    page.answer(("brow", 3), "BrowUp")
    assert page.answer(("brow", 2), 3).status_code == 200
    merged = page.answer(("brow", 1), 2)
    assert merged.json["now"] == said(3)
    assert page.answer(("brow", 3), "BrowDown", was="BrowUp").status_code == 200
    answers = page.labelling.persons.of("")
    assert answers.named("brow", 1) == Answer("BrowDown")
    assert page.answer(("brow", 3), 0, was="BrowDown").status_code == 200  # of a root, too
    assert answers.root("brow", 1) == 0
    assert page.answer(("brow", 1), None, was=2).status_code == 200  # as the page had asked


def test_those_merged_into_a_cluster_stay_so_when_its_answer_is_taken_back(label_page):
    page = label_page()
    page.answer(("brow", 3), "BrowUp")
    page.answer(("brow", 2), 3)
    page.answer(("brow", 3), None, was="BrowUp")
    assert page.written()["brow"].clusters == {2: Answer(same_as=3)}
    assert ["brow", 3] in page.state()["next"] and ["brow", 2] not in page.state()["next"]
    assert page.labelling.persons.of("").named("brow", 2) is None  # as its root is proposed


@pytest.mark.parametrize("target", [0, 1, 2, 4, -1])
def test_a_merger_with_itself_in_a_circle_or_with_nothing_is_refused(label_page, target):
    page = label_page()
    page.answer(("brow", 1), 0)
    page.answer(("brow", 2), 1)
    assert page.answer(BROW, target).status_code == 400
    assert 0 not in page.written()["brow"].clusters


def test_clusters_that_a_hand_merged_in_a_circle_do_not_hang_the_page(label_page):
    page = label_page()
    page.answer(BROW, 1)
    page.answer(("brow", 2), "BrowUp")
    text = page.file.read_text().replace("2: BrowUp", "1: {same_as: 0}\n    2: BrowUp")
    page.file.write_text(text)
    for answer in (page.get("/state"), page.answer(("brow", 3), "BrowUp")):
        assert answer.status_code == 500 and "the same as" in answer.text
    assert page.file.read_text() == text


@pytest.mark.parametrize(
    "now",
    [
        "Smile",
        "browup",
        "",
        "<b>",
        ("BrowUp", ""),
        ("BrowUp", "two\nlines"),
        ("BrowUp", " led"),
        ("BrowUp", "x" * (MOST_CHARACTERS + 1)),
        ("BrowUp", "=cmd()"),
        (None, "strong"),
    ],
)
def test_a_name_that_is_none_is_refused(label_page, now):
    page = label_page()
    assert page.answer(BROW, now).status_code == 400
    assert not page.file.exists()


WHOLE = {"person": "", "region": "brow", "cluster": 0, "was": None, "now": None, "shown": []}


@pytest.mark.parametrize(
    "change",
    [
        {"person": None},
        {"person": "a b"},
        {"person": "../up"},
        {"person": "x" * 33},
        {"cluster": "0"},
        {"cluster": True},
        {"cluster": 0.0},
        {"now": {"action": None, "note": None, "same_as": 10**30}},
        {"now": {"action": "\ud800", "note": None, "same_as": None}},
        {"now": "BrowUp"},
        {"now": {}},
        {"now": {"action": 1, "note": None, "same_as": None}},
        {"now": {"action": None, "note": None, "same_as": True}},
        {"now": {"action": "BrowUp", "note": None, "same_as": 1}},
        {"shown": None},
        {"shown": [99]},
        {"shown": ["0"]},
        {"shown": [[0]]},
    ],
)
def test_a_post_of_another_shape_changes_nothing(label_page, change):
    page = label_page()
    assert page.post(WHOLE | change).status_code == 400
    assert not page.file.exists()


@pytest.mark.parametrize(
    "change", [{"region": "eye"}, {"region": "nose"}, {"cluster": 4}, {"cluster": 10**30}]
)
def test_only_clusters_of_the_run_are_answered(label_page, change):
    page = label_page()
    assert page.post(WHOLE | change).status_code == 404
    assert not page.file.parent.exists()


ANSWERS = st.one_of(
    st.none(),
    st.just("not sure"),
    st.sampled_from(["BrowUp", "BrowDown", "Neutral"]),
    st.tuples(st.just("BrowUp"), st.text(max_size=6)),
    st.integers(-1, 5),
)


@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(posts=st.lists(st.tuples(st.integers(0, 3), ANSWERS, st.booleans()), max_size=12))
def test_whatever_is_posted_the_file_holds_what_was_accepted_and_names_end(
    fitted_once, tmp_path_factory, label_page, posts
):
    page = label_page()
    page.file.unlink(missing_ok=True)
    held = {}
    for cluster, now, stale in posts:
        was = held.get(cluster) if not stale else said("Neutral")
        body = WHOLE | {"cluster": cluster, "was": was, "now": said(now)}
        answer = page.post(body)
        assert answer.status_code in (200, 400, 409)
        if answer.status_code == 200:
            held[cluster] = answer.json["now"]
        elif answer.status_code == 409:
            assert answer.json["holds"] == held.get(cluster)
    held = {str(n): answer for n, answer in held.items() if answer is not None}
    fresh = label_page()
    assert fresh.get("/answers").json["answers"]["brow"] == held
    answers = fresh.labelling.persons.of("")
    for cluster in range(4):
        root = answers.of("brow", answers.root("brow", cluster))
        assert root is None or root.same_as is None


# --- persons ------------------------------------------------------------------------------------


def test_a_second_person_is_told_nothing_of_proposals_before_they_answer(label_page):
    page = label_page()
    page.answer(BROW, "BrowUp")
    page.answer(("brow", 1), "Neutral")
    page.answer(BROW, "BrowDown", person="bo", shown=[0])
    state = page.state("bo")
    clusters = {(r["name"], c["number"]): c for r in state["regions"] for c in r["clusters"]}
    assert clusters.pop(BROW)["proposed"]["action"] == "BrowUp"
    for cluster in clusters.values():
        assert (cluster["proposed"], cluster["answer"], cluster["purity"]) == (None, None, None)
        assert (cluster["agreement"], cluster["n_shown"]) == (None, 0)
    assert len(state["next"]) == 6
    worth = [clusters[region, number]["worth"] for region, number in map(tuple, state["next"])]
    assert len(set(worth)) == 2  # the regions' shares alone
    assert state["persons"] == ["", "bo"] and state["command"] == ""
    assert page.get("/answers?person=bo").json["answers"]["brow"] == {"0": said("BrowDown")}
    assert page.written()["brow"].clusters[0] == Answer("BrowUp")
    assert page.labelling.persons.path("bo").name == "names.bo.yaml"


def test_to_a_second_person_all_is_the_same_whatever_was_proposed_or_answered(label_page, fitted):
    def told(page) -> list:
        state = page.state("bo")
        beside = [page.get(f"/exemplars/brow/{n}?person=bo").json for n in range(4)]
        return [state["regions"], state["next"], state["command"], *beside]

    before = told(label_page(fitted))
    path = fitted / "label" / "proposed.parquet"
    rows = tables.read(tables.LABELS, path)
    others = rows.assign(action="Neutral", confidence=0.31, why=None, note="of the rule")
    tables.write(tables.LABELS, others, path)
    path = fitted / "label" / "profiles.parquet"
    tables.write(tables.PROFILES, tables.read(tables.PROFILES, path).assign(purity=0.2), path)
    page = label_page(fitted)
    page.answer(BROW, "BrowDown")
    page.answer(("brow", 1), 0)
    assert page.state()["regions"] != before[0] and told(page) == before


def test_the_agreement_is_over_clusters_that_both_answered(label_page):
    page = label_page()
    for number, (first, second) in enumerate([("BrowUp", "BrowUp"), ("Neutral", "BrowDown")]):
        page.answer(("brow", number), first)
        page.answer(("brow", number), second, person="bo")
    page.answer(("mouth", 0), "Smile")
    page.answer(("mouth", 1), "Neutral", person="bo")
    found = page.get("/agreement?person=bo").json
    assert found["n"] == 2 and found["same"] == 0.5 and found["kappa"] is not None
    assert found["differing"] == [
        {"region": "brow", "cluster": 1, "first": said("Neutral"), "second": said("BrowDown")}
    ]
    nobody = page.get("/agreement?person=cy").json
    assert nobody["n"] == 0 and nobody["kappa"] is None and nobody["differing"] == []
    assert page.get("/agreement?person=").json == nobody


def test_the_person_of_the_command_is_meant_where_the_page_does_not_say(label_page):
    page = label_page(person="bo")
    assert page.state()["person"] == "bo"
    assert label_page().state()["person"] == ""


def test_a_page_that_was_started_for_a_second_person_tells_nothing_of_the_first(label_page):
    first = label_page()
    first.answer(BROW, ("BrowUp", "of the first"))
    page = label_page(person="bo")
    assert page.state("")["person"] == "bo" and page.cluster(*BROW)["answer"] is None
    assert page.get("/answers?person=").json["answers"]["brow"] == {}
    assert page.get("/agreement?person=").json["n"] == 0
    assert page.answer(BROW, "Neutral").status_code == 200  # of nobody in particular
    assert page.written("bo")["brow"].clusters == {0: Answer("Neutral")}
    assert page.written()["brow"].clusters == {0: Answer("BrowUp", "of the first")}
    texts = [page.get(path).text for path in ("/", "/state?person=", "/exemplars/brow/1")]
    assert not any("of the first" in text for text in texts)


def test_a_person_is_the_same_in_capitals(label_page):
    page = label_page()
    assert page.answer(BROW, "BrowUp", person="Bo").status_code == 200
    assert page.written("bo")["brow"].clusters == {0: Answer("BrowUp")}
    assert page.state("BO")["persons"] == ["", "bo"]


@pytest.mark.parametrize("person", ["a b", "../x", "é", "x" * 33, "a.b", "a/b", "a\0"])
def test_a_person_s_name_that_cannot_stand_in_a_file_s_is_refused(label_page, person):
    page = label_page()
    assert page.get("/state", query_string={"person": person}).status_code == 400
    with pytest.raises(BadConfig, match="letters, digits"):
        page.labelling.persons.of(person)


# --- refits -------------------------------------------------------------------------------------


def test_names_of_the_fit_before_are_shown_as_moved_and_written_with_the_first_answer(
    label_page, fitted
):
    page = label_page(fitted)
    for number, name in enumerate(("BrowUp", "BrowDown", "Neutral")):
        page.answer(("brow", number), name)
    page.answer(("brow", 0), ("BrowUp", "strong"), was="BrowUp", shown=[0, 1])
    page.answer(("mouth", 0), "Smile")
    before = page.file.read_text()
    refit(fitted, "brow", 1, MOVED)
    page = label_page(fitted)
    state = page.state()
    assert state["regions"][0]["moved"]["kept"] > 0.9 and state["regions"][2]["moved"] is None
    moved = page.cluster("brow", 1)
    assert moved["answer"] == said(("BrowUp", "strong")) and moved["agreement"] > 0.9
    assert page.file.read_text() == before and len(state["next"]) == 1 + 2
    as_it_is = ("BrowUp", "strong")
    assert page.answer(("brow", 1), as_it_is, was=as_it_is).status_code == 200
    written = page.written()
    assert written["brow"].model == MOVED and written["mouth"].clusters == {0: Answer("Smile")}
    assert {n: a.action for n, a in written["brow"].clusters.items()} == {
        1: "BrowUp",
        2: "BrowDown",
        3: "Neutral",
    }
    assert written["brow"].shown == {1: ((HOSTILE, 0, 10), ("film_1", 0, 10))}
    assert page.cluster("brow", 1)["agreement"] is None
    assert page.state()["regions"][0]["moved"] is None


def test_what_no_name_could_be_moved_to_is_shown_first_and_stays_open_until_answered(
    label_page, fitted
):
    page = label_page(fitted)
    for number, name in enumerate(("BrowUp", "BrowDown", "Neutral", "BrowUp")):
        page.answer(("brow", number), name)
    before = page.written()["brow"].model
    path = fitted / "segment" / "brow" / "clusters.parquet"
    refit(fitted, "brow", 0, MOVED)
    clusters = tables.read(tables.CLUSTERS, path)
    old, few = clusters["cluster"], clusters["frame"] % 4 == 0
    new = old.mask((old == 0) & ~few, 3).mask((old == 1) & few, 0)  # 0 was as much up as down
    clusters["cluster"] = new
    tables.write(tables.CLUSTERS, clusters, path)
    page = label_page(fitted)
    assert page.cluster(*BROW)["unsafe"] and page.cluster(*BROW)["answer"] is None
    assert page.state()["next"][0] == ["brow", 0]
    page.answer(("brow", 2), "Neutral", was="Neutral")
    assert page.written()["brow"].open == {0}
    assert kept_copy(page.file, "brow", before).exists()  # with the names of the fit before
    again = label_page(fitted)
    for one in (page, again):
        assert one.state()["next"][0] == ["brow", 0] and one.cluster(*BROW)["unsafe"]
    page.answer(BROW, "BrowUp")
    assert ["brow", 0] not in page.state()["next"] and not page.cluster(*BROW)["unsafe"]
    page.answer(BROW, None, was="BrowUp")  # undone
    assert page.written()["brow"].open == {0} and page.state()["next"][0] == ["brow", 0]
    page.answer(BROW, "not sure")
    assert ["brow", 0] not in page.state()["next"] and not page.cluster(*BROW)["unsafe"]
    assert page.written()["brow"].clusters[0] == Answer()


def test_a_page_whose_run_was_refitted_says_so_and_writes_nothing(label_page, fitted):
    page = label_page(fitted)
    page.answer(BROW, "BrowUp")
    before = page.file.read_text()
    refit(fitted, "brow", 1, MOVED)
    for answer in (page.answer(("brow", 1), "Neutral"), page.get("/exemplars/brow/0")):
        assert answer.status_code == 500
        assert "refitted meanwhile" in answer.text and "mimeline label again" in answer.text
    shutil.rmtree(fitted / "segment" / "mouth" / "model")  # while it is fitted
    assert "refitted meanwhile" in page.get("/state").text
    fitted.rename(fitted.with_name("elsewhere"))
    assert "the results were moved or deleted" in page.get("/state").text
    assert page.file.read_text() == before


# --- start and end ------------------------------------------------------------------------------


def test_a_folder_without_a_run_and_a_run_without_exemplars_are_plain_errors(tmp_path, fitted):
    with pytest.raises(NoSuchFile, match=r"no run.*--until exemplars.*--results"):
        ClustersOfRun(tmp_path / "none")
    told = {"config": {}, "files": ["my run.yaml"], "given": ["data_dir=clips"]}
    (fitted / "run.json").write_text(json.dumps(told))
    (fitted / "label" / "exemplars.parquet").unlink()
    whole = r"--until exemplars --configfile 'my run\.yaml' --config data_dir=clips`"
    with pytest.raises(NoSuchFile, match=rf"no exemplars yet.*{whole}"):
        ClustersOfRun(fitted)


def test_a_run_without_a_cluster_says_why(fitted):
    for name, table in (("proposed", tables.LABELS), ("exemplars", tables.EXEMPLARS)):
        tables.write(table, tables.empty(table), fitted / "label" / f"{name}.parquet")
    with pytest.raises(NoSuchFile, match=r"no cluster.*eye: not measured"):
        ClustersOfRun(fitted)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[", "YAML"),
        ("brow: 3", "model and clusters"),
        ("nose: {model: x, clusters: {0: Neutral}}", "one of brow, eye, mouth"),
        (f"brow: {{model: {FITS['brow']}, clusters: {{9: Neutral}}}}", "cluster 9"),
        (f"brow: {{model: {FITS['brow']}, clusters: {{0: Smile}}}}", "Smile"),
        ("<<<<<<< ours\nbrow: {}\n=======\n>>>>>>> theirs\n", "line 1.*conflict"),
    ],
)
def test_a_label_file_that_does_not_fit_is_a_plain_error_and_is_left_alone(
    label_page, names, text, complaint
):
    names.parent.mkdir()
    names.write_text(text)
    with pytest.raises(BadLabels, match=complaint):
        label_page().labelling.persons.of("")
    assert names.read_text() == text


def test_a_place_where_no_label_file_can_be_is_a_plain_error(fitted, names):
    def start(file):
        serve(fitted, file, "", 0, open_browser=False, say=print)

    names.parent.mkdir()
    with pytest.raises(BadFile, match="found a folder, expected a file"):
        start(names.parent)
    (names.parent / "loop.yaml").symlink_to("loop.yaml")
    with pytest.raises(BadFile, match=r"loop\.yaml.*expected a file"):
        start(names.parent / "loop.yaml")
    with pytest.raises(BadConfig, match=r"labels\.yaml, a file of the run itself.*Copy it"):
        start(fitted / "label" / "labels.yaml")


def test_a_file_that_was_spoilt_meanwhile_is_not_written_over(label_page):
    page = label_page()
    page.answer(BROW, "BrowUp")
    page.file.write_text("no label file at all")
    answer = page.answer(("brow", 1), "Neutral")
    assert answer.status_code == 500 and "names.yaml" in answer.text
    assert page.file.read_text() == "no label file at all"


def test_a_place_that_cannot_be_written_to_is_said_and_tried_again(label_page):
    page = label_page()
    page.file.parent.write_text("a file where the folder should be")
    answer = page.answer(BROW, "BrowUp")
    assert answer.status_code == 500
    page.file.parent.unlink()
    assert page.answer(BROW, "BrowUp").status_code == 200


@pytest.mark.parametrize(
    ("folder", "told", "file"),
    [
        ("results", None, "config/labels/labels.yaml"),
        ("results-mine", None, "config/labels/mine.yaml"),
        ("other", None, "config/labels/other.yaml"),
        ("results", "mine.yml", "mine.yml"),
    ],
)
def test_the_label_file_is_the_run_s_own_or_named_after_it(
    fitted_once, tmp_path, folder, told, file
):
    results = shutil.copytree(fitted_once, tmp_path / "at" / folder)
    content = {"config": {"label": {"file": told}}, "files": [], "given": []}
    (results / "run.json").write_text(json.dumps(content))
    assert own_file(ClustersOfRun(results)) == Path(file)


def test_the_end_says_what_is_named_what_is_left_and_how_to_go_on(label_page):
    page = label_page()
    assert "snakemake" not in closing(page.labelling, "", 0.0)
    page.answer(BROW, "BrowUp")
    page.answer(("brow", 1), 0)
    page.answer(("brow", 2), "not sure")
    page.answer(("mouth", 1), 0)  # whose name is proposed
    text = closing(page.labelling, "", 90.0)
    assert "2 of 7 clusters are named: brow 2 of 4 and mouth 0 of 3, in 90 s." in text
    assert "1 is left as not sure" in text and "4 are left to the proposals" in text
    *words, chosen = shlex.split(text.rpartition("\n")[2])
    assert words[:5] == ["snakemake", "--cores", "2", "--until", "annotate"]
    assert yaml.safe_load(chosen.removeprefix("label=")) == {"file": str(page.file)}
    page.answer(BROW, "BrowUp", person="bo")
    text = closing(page.labelling, "bo", 0.0)
    assert "gave the same one name to all 1 cluster that both named: that is no kappa" in text
    page.answer(("brow", 1), "BrowDown", person="bo")
    text = closing(page.labelling, "bo", 0.0)
    assert "Kappa with the first person: 0.00, over 2 clusters that both named." in text
    assert "names.bo.yaml" in text


def test_pauses_are_no_work():
    back = 115.0 + PAUSE_S + 1
    times = iter([100.0, 110.0, 115.0, back, back + 20])
    watch = Stopwatch(lambda: next(times))
    for _ in range(5):
        watch.tick()
    assert watch.active_s == 15.0 + 20.0


@pytest.mark.parametrize(
    "path", ["/", "/state", "/exemplars/brow/0", "/pictures/face/brow/0/0", "/answers"]
)
def test_nothing_is_told_to_who_has_no_key_or_another_name(label_page, path):
    page = label_page()
    stranger = page.client.application.test_client()
    assert stranger.get(path, base_url=page.base).status_code == 403
    assert page.client.get(path, base_url="http://evil.example").status_code == 403
    assert page.get(path, headers={"Sec-Fetch-Site": "same-site"}).status_code == 403
    assert page.get(path).headers["Content-Security-Policy"].startswith("default-src 'none'")


def test_a_post_from_another_page_or_in_another_form_changes_nothing(label_page):
    page = label_page()
    for headers in ({}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:9999"}):
        answer = page.client.post("/answers", json=WHOLE, base_url=page.base, headers=headers)
        assert answer.status_code == 403
    ours = {"Origin": page.base}
    form = page.client.post("/answers", data=WHOLE, base_url=page.base, headers=ours)
    assert form.status_code == 415
    assert page.post(WHOLE | {"more": "x" * MOST_BYTES}).status_code == 413
    assert not page.file.parent.exists()


def test_the_page_loads_nothing_from_elsewhere_and_runs_nothing_inline(label_page):
    page = label_page()
    text = page.get("/").text
    assert not re.findall(r"<script(?![^>]*\bsrc=)|<style|\sstyle=|\son\w+=|https?://", text)
    loaded = re.findall(r'(?:src|href)="([^"]+)"', text)
    assert loaded and all(page.get(path).status_code == 200 for path in loaded)


def test_the_command_serves_until_it_is_ended_and_says_how_to_go_on(fitted_once, names):
    command = [sys.executable, "-c", "from mimeline.cli import main; main()", "label"]
    command += ["--results", str(fitted_once), "--file", str(names), "--no-browser"]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/\?key=\S+", child.stdout.readline())[0]
        with urllib.request.urlopen(address, timeout=60) as answer:
            assert answer.status == 200
        child.send_signal(signal.SIGINT)
        told, complaint = child.communicate(timeout=60)
    finally:
        child.kill()
    assert child.returncode == 0 and complaint == ""
    assert "0 of 7 clusters are named" in told and "snakemake" not in told
    assert not names.exists()


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.sampled_from(["brow", "mouth", "eye", "Neutral", "bo", 10**400, "\ud800"])
    | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["action", "note", "same_as"]), inner, max_size=3)
    ),
    max_leaves=6,
)
ROUTES = ("/", "/state", "/answers", "/agreement", "/exemplars/", "/exemplars/brow/", "/pictures/")


@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    body=st.one_of(JSON, st.fixed_dictionaries({}, optional=dict.fromkeys(WHOLE, JSON))),
    path=st.tuples(st.sampled_from(ROUTES), st.text(max_size=8) | st.just("9" * 5000)),
    query=st.dictionaries(st.sampled_from(["person", "known", "key"]), st.text(max_size=5)),
)
def test_whatever_is_asked_or_posted_is_answered_or_refused(idle_label_page, body, path, query):
    page = idle_label_page
    route, end = path
    asked = page.get(route + quote(end, errors="replace"), query_string=query)
    posted = page.post(WHOLE | body if isinstance(body, dict) else body)
    assert asked.status_code in (200, 308, 400, 403, 404)  # 308: of two slashes, one
    assert posted.status_code in (200, 400, 404, 409, 415)


def test_hostile_texts_reach_the_page_as_data_alone(label_page):
    page = label_page()
    answer = page.get("/exemplars/brow/0")
    assert answer.mimetype == "application/json"
    assert answer.json["exemplars"][0]["clip_id"] == HOSTILE
    assert HOSTILE not in page.get("/").text


def test_answers_of_a_region_that_could_not_be_segmented_now_are_kept(label_page, names):
    names.parent.mkdir()
    names.write_text("eye:\n  model: e0\n  clusters:\n    0: EyeWiden\n")
    label_page().answer(BROW, "BrowUp")
    assert read_label_file(names)["eye"].clusters == {0: Answer("EyeWiden")}


def test_a_broken_table_of_the_run_is_a_plain_error(fitted):
    (fitted / "label" / "exemplars.parquet").write_bytes(b"no table")
    with pytest.raises(BadFile, match=r"exemplars\.parquet"):
        ClustersOfRun(fitted)

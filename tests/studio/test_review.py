import re
import shlex
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pandas as pd
import pytest
import yaml

from mimeline import cli, tables
from mimeline.errors import BadFile, NoSuchFile
from mimeline.studio.decisions import Decisions
from mimeline.studio.review import clips_with_films, closing

STUDIO = Path(__file__).parents[2] / "src" / "mimeline" / "studio"
HOSTILE = '<img src=x onerror="alert(1)">'


def test_a_clip_is_listed_with_what_became_of_it(idle_page):
    clips = idle_page.get("/clips").json
    names = ("id", "status", "why", "film")
    assert list(zip(*(clips[name] for name in names), strict=True)) == [
        ("-a_1", "kept", None, True),
        ("b_1", "kept", None, True),
        ("c_1", "dropped", "the head turns too far", True),
        ("d_1", "dropped", "too short", False),
        ("e_1", "kept", None, False),
    ]


def test_the_facts_of_a_clip_are_told_in_words(idle_page):
    clip = idle_page.get("/clips/c_1").json
    facts = dict(clip["facts"])
    assert (facts["Size"], facts["Frames"]) == ("512 × 512 px", "180 at 30 fps")
    assert clip["tracks"] == [
        {"name": "head wagging", "kind": "action", "spans": [[1.0, 3.0, 1.0]]}
    ]
    assert [row["stage"] for row in clip["ledger"]] == ["catalogue", "select", "fetch", "pose"]
    assert clip["ledger"][-1] == {
        "stage": "pose",
        "status": "dropped",
        "rule": "the head turns too far",
        "measured": "41°, limit 35°",
        "frames": [30, 44],
        "detail": "",
    }


def test_what_nobody_timed_is_a_fact_and_no_track(page, results):
    path = results / "pose" / "00" / "clips.parquet"
    rows = tables.read(tables.CLIPS, path)
    sometime = {"name": "play_instrument", "start_s": 0.0, "end_s": 6.0, "uncertainty_s": None}
    rows["actions"] = [[*actions, sometime] for actions in rows["actions"]]
    tables.write(tables.CLIPS, rows, path)
    clip = page().get("/clips/b_1").json
    assert dict(clip["facts"])["At some time"] == "play instrument"
    assert [track["name"] for track in clip["tracks"]] == ["head wagging"]


def test_a_clip_without_a_film_says_why(idle_page):
    assert "too short" in idle_page.get("/clips/d_1").json["no_film"]
    assert "tracking alone" in idle_page.get("/clips/e_1").json["no_film"]
    assert idle_page.get("/clips/b_1").json["no_film"] == ""


def test_a_stage_that_is_older_than_the_loss_is_passed_over(page, results):
    path = results / "pose" / "00" / "ledger.parquet"
    rows = tables.read(tables.LEDGER, path)
    stale = rows[rows["clip_id"] == "b_1"].assign(clip_id="d_1")
    tables.write(tables.LEDGER, pd.concat([rows, stale]), path)
    stages = [row["stage"] for row in page().get("/clips/d_1").json["ledger"]]
    assert stages == ["catalogue", "select"]


def test_decisions_are_in_the_file_at_once_and_survive_a_restart(page):
    first = page()
    assert first.decide("-a_1", (True, None)).status_code == 200
    assert not first.exclusions.exists()
    assert first.decide("b_1", (True, "occlusion")).status_code == 200
    assert first.exclusions.read_text() == "clip_id,reason\nb_1,occlusion\n"
    assert first.decide("c_1", (True, "subtitles, large")).status_code == 200
    again = page().state()
    assert again["reasons"] == {"b_1": "occlusion", "c_1": "subtitles, large"}
    assert again["seen"] == ["-a_1", "b_1", "c_1"]


def test_what_is_undone_is_as_it_was(page):
    page = page()
    page.decide("b_1", (True, "occlusion"))
    page.decide("b_1", (True, "wrong_crop"), was=(True, "occlusion"))
    page.decide("b_1", (True, "occlusion"), was=(True, "wrong_crop"))
    assert page.listed() == {"b_1": "occlusion"}
    page.decide("b_1", (False, None), was=(True, "occlusion"))
    state = page.state()
    assert page.listed() == {} and state["seen"] == [] and state["reasons"] == {}


def test_rows_of_other_runs_and_of_others_meanwhile_are_kept(page):
    page = page()
    page.exclusions.parent.mkdir()
    page.exclusions.write_text("clip_id;reason\nelsewhere;beard\n")
    page.decide("b_1", (True, "occlusion"))
    page.exclusions.write_text(page.exclusions.read_text() + "another,mask\n")
    page.decide("c_1", (True, "low_quality"))
    assert page.listed() == {
        "another": "mask",
        "b_1": "occlusion",
        "c_1": "low_quality",
        "elsewhere": "beard",
    }


def test_of_two_pages_that_write_at_once_neither_loses_a_decision(page, exclusions):
    pages = {clip_id: page() for clip_id in ("-a_1", "b_1", "c_1")}  # which share the list alone

    def decide_often(clip_id: str) -> list[int]:
        was, codes = (False, None), []
        for now in [(True, "occlusion"), (True, None)] * 8 + [(True, "beard")]:
            codes.append(pages[clip_id].decide(clip_id, now, was=was).status_code)
            was = now
        return codes

    with ThreadPoolExecutor(len(pages)) as threads:
        codes = list(threads.map(decide_often, pages))
    assert codes == [[200] * 17] * 3  # 409 where what one had decided was gone
    assert page().listed() == dict.fromkeys(pages, "beard")


def test_of_two_tabs_the_one_that_did_not_see_the_other_is_told(page):
    here, there = page(), page()
    assert here.decide("b_1", (True, "occlusion")).status_code == 200
    refused = there.decide("b_1", (True, None))
    assert refused.status_code == 409
    assert (refused.json["seen"], refused.json["reason"]) == (True, "occlusion")
    assert there.listed() == {"b_1": "occlusion"}
    assert there.decide("b_1", (True, "occlusion")).status_code == 200  # both say the same


def test_what_others_decide_is_shown_and_what_did_not_change_is_not_sent(page):
    here, there = page(), page()
    known = here.state()["revision"]
    assert here.get(f"/decisions?known={known}").json == {"revision": known}
    there.decide("b_1", (True, "occlusion"))
    assert here.get(f"/decisions?known={known}").json["reasons"] == {"b_1": "occlusion"}


@pytest.mark.parametrize(
    "reason", ["", " ", "two\nlines", "=cmd()", "+1", "-1", "@x", "x" * 201, "bell\a", " led"]
)
def test_a_reason_that_would_spoil_the_list_is_refused(idle_page, reason):
    assert idle_page.decide("b_1", (True, reason)).status_code == 400
    assert not idle_page.exclusions.exists()


def test_a_reason_of_somebody_else_comes_back_whatever_it_is(page):
    page = page()
    page.exclusions.parent.mkdir()
    page.exclusions.write_text("clip_id,reason\nb_1,=odd\n")
    page.decide("b_1", (True, None), was=(False, "=odd"))
    assert page.decide("b_1", (False, "=odd"), was=(True, None)).status_code == 200
    assert page.listed() == {"b_1": "=odd"}


@pytest.mark.parametrize(
    "body",
    [
        [],
        {},
        {"clip_id": 3, "was": {}, "now": {}},
        {"clip_id": "b_1", "was": None, "now": {"seen": True, "reason": None}},
        {"clip_id": "b_1", "was": {"seen": 1, "reason": None}, "now": {"seen": True, "reason": 2}},
    ],
)
def test_a_post_of_another_shape_is_refused(idle_page, body):
    answer = idle_page.client.post(
        "/decisions", json=body, base_url=idle_page.base, headers={"Origin": idle_page.base}
    )
    assert answer.status_code == 400


@pytest.mark.parametrize("clip_id", ["none", "../b_1", "b_1\0", "", "b_1\nx,y"])
def test_only_clips_of_the_run_are_decided_on(idle_page, clip_id):
    assert idle_page.decide(clip_id, (True, "occlusion")).status_code == 404
    assert not idle_page.exclusions.exists()


def test_hostile_texts_reach_the_page_as_data_alone(idle_page):
    answer = idle_page.get("/clips/e_1")
    assert answer.mimetype == "application/json" and answer.json["texts"] == [HOSTILE]
    assert HOSTILE not in idle_page.get("/").text
    markup = r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b|new Function"
    scripts = list((STUDIO / "static").glob("*.js"))
    assert scripts and not [p.name for p in scripts if re.search(markup, p.read_text())]


def test_a_hostile_folder_name_is_text(results, exclusions, tmp_path):
    from mimeline.studio.review import review

    moved = results.rename(tmp_path / "<b>run")
    app = review(clips_with_films(moved), Decisions(exclusions), "the-key")
    client = app.test_client()
    client.get("/?key=the-key", base_url="http://127.0.0.1")
    text = client.get("/", base_url="http://127.0.0.1").text
    assert "<b>run" not in text and "&lt;b&gt;run" in text


def test_the_page_loads_nothing_from_elsewhere_and_runs_nothing_inline(idle_page):
    text = idle_page.get("/").text
    assert not re.findall(r"<script(?![^>]*\bsrc=)|<style|\sstyle=|\son\w+=|https?://", text)
    for path in re.findall(r'(?:src|href)="([^"]+)"', text):
        assert idle_page.get(path).status_code == 200
    for path in filter(Path.is_file, (STUDIO / "static").iterdir()):
        assert not re.findall(r"https?://(?!www\.w3\.org/2000/svg)", path.read_text())


def test_every_button_of_the_page_does_something(idle_page):
    scripts = "\n".join(path.read_text() for path in (STUDIO / "static").glob("*.js"))
    heard = set(re.findall(r'byId\("([\w-]+)"\)\.addEventListener\("click"', scripts))
    ids = set(re.findall(r'<button[^>]*\bid="([\w-]+)"', idle_page.get("/").text))
    assert ids and ids <= heard


def test_a_list_that_cannot_be_kept_whole_is_refused(exclusions):
    exclusions.parent.mkdir()
    exclusions.write_text("clip_id,reason,who\nb_1,occlusion,me\n")
    with pytest.raises(BadFile, match="also the columns who"):
        Decisions(exclusions)


def test_a_list_that_was_spoilt_meanwhile_is_not_written_over(page):
    page = page()
    page.exclusions.parent.mkdir()
    page.exclusions.write_text("no list at all\n")
    answer = page.decide("b_1", (True, "occlusion"))
    assert answer.status_code == 500 and "exclusions.csv" in answer.text
    assert page.exclusions.read_text() == "no list at all\n"


def test_a_folder_without_a_run_is_a_plain_error(tmp_path):
    with pytest.raises(NoSuchFile, match="--results"):
        clips_with_films(tmp_path)


def test_a_run_without_films_has_nothing_to_show(results):
    shutil.rmtree(results / "fetch" / "00" / "media")
    with pytest.raises(NoSuchFile, match=r"no film of its 5 clips.*fetch\.folder"):
        clips_with_films(results)


def test_the_command_at_the_end_can_be_pasted_whatever_the_list_is_called(results, tmp_path):
    path = tmp_path / "it's, a {list}.csv"
    path.write_text("clip_id,reason\nb_1,occlusion\n")
    said = closing(clips_with_films(results), Decisions(path), path)
    *_, chosen = shlex.split(said.rpartition("\n")[2])
    assert yaml.safe_load(chosen.removeprefix("select=")) == {"exclusions": str(path)}


def test_the_end_says_nothing_of_a_list_that_was_not_begun(results, exclusions):
    clips, decisions = clips_with_films(results), Decisions(exclusions)
    said = closing(clips, decisions, exclusions)
    assert "0 clips looked at, 0 left out" in said and "snakemake" not in said


def test_the_manual_names_every_option_and_key(idle_page):
    manual = (STUDIO.parents[2] / "docs" / "review.md").read_text(encoding="utf-8")
    offered = cli._parser()._subparsers._group_actions[0].choices["review"].format_help()
    told = {option for option in re.findall(r"--[a-z-]+", manual) if option in offered}
    assert told == set(re.findall(r"--[a-z-]+", offered)) - {"--help"}
    help = idle_page.get("/").text.partition('id="help"')[2].partition("</dl>")[0]
    keys = re.findall(r"<kbd>(.+?)</kbd>", help)
    assert len(keys) > 12 and not [key for key in keys if f"`{key}`" not in manual]

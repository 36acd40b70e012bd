import json
import shutil

import pytest
import yaml

from mimeline import tables
from mimeline.errors import BadFile, NoSuchFile
from mimeline.inspection import remedies
from mimeline.inspection.funnel import funnel
from mimeline.inspection.why import as_json, as_text, why
from mimeline.run import Run, remember

from .conftest import OPTIONS


def told(results, *asked) -> str:
    return " ".join(as_text(why(results, asked)).split())


def test_a_dropped_clip_tells_rule_value_limit_and_what_to_do(run_results):
    text = told(run_results, "-long")
    assert "-long: dropped by select: too long" in text
    assert "too long: 12.7 s, limit 10 s" in text
    assert "Set select.max_s to 12.7 in config/config.yaml" in text
    assert "then type again: snakemake --cores 2" in text
    assert f"mimeline funnel --results {run_results} --set select.max_s=12.7" in text
    assert "fetch, ingest, pose, split: none of them saw it" in text


def test_a_turned_head_tells_its_frames_and_where_its_motion_lies(run_results):
    text = told(run_results, "looks_away")
    assert "the head turns too far: 41.2°, limit 35°, frames 60–89" in text
    assert str(run_results / "ingest" / "00" / "motion.parquet") in text
    assert "Set pose.max_yaw_deg to 41.3" in text


def test_a_kept_clip_tells_what_was_not_applied_and_what_has_not_run(run_results):
    text = told(run_results, "good_1")
    assert "good_1: kept so far, by pose" in text
    assert "was not applied: the catalogue does not give the size of the crop" in text
    assert "split: not run yet" in text and "what to do" not in text


def test_a_failed_clip_that_can_be_tried_again_says_how(run_results):
    text = told(run_results, "lost")
    assert "failed by fetch" in text and "a removed video" in text
    assert "snakemake --cores 2 --forcerun fetch" in text


def test_the_catalogue_s_words_on_a_clip_are_shown(run_results):
    text = told(run_results, "turning")
    assert "source t, 0–6 s (6 s)" in text and "actions turn 1–2 s ± 1" in text
    assert "crop 600 x 700 pixels" in told(run_results, "good_0")
    assert "emotion happy" in told(run_results, "good_0")


def test_an_id_brings_the_records_that_repeat_it(run_results):
    assert [s.clip_id for s in why(run_results, ["good_0"]).stories] == ["good_0", "good_0#2"]
    (story,) = why(run_results, ["good_0#2"]).stories
    assert story.outcome.startswith("failed by catalogue") and not story.facts


def test_a_source_and_a_pattern_list_their_clips_with_a_line_each(run_results):
    assert [s.clip_id for s in why(run_results, ["good"]).stories] == [
        "good_0",
        "good_1",
        "good_1b",
    ]
    text = as_text(why(run_results, ["*"]))
    assert text.startswith("10 clips, 2 kept\n") and len(text.splitlines()) == 11
    assert [s.clip_id for s in why(run_results, ["s*", "short"]).stories] == ["short", "small"]


def test_an_id_that_nobody_has_ends_with_those_near_it(run_results):
    with pytest.raises(BadFile, match="Near it: looks_away"):
        why(run_results, ["loks_away"])
    with pytest.raises(BadFile, match="Near it: good_0, good_0#2, good_1, good_1b, good"):
        why(run_results, ["GOOD"])
    with pytest.raises(BadFile, match="mimeline funnel --results .* lists"):
        why(run_results, ["zzzzqqqq"])
    with pytest.raises(BadFile, match="'x\\*'"):
        why(run_results, ["x*"])


def test_names_near_an_id_are_those_of_clips_before_sources(run_results):
    with pytest.raises(BadFile, match="Near it: good_1, good_0, good_1b, good_0#2, good.$"):
        why(run_results, ["good_l"])


def test_an_id_may_end_as_its_key_in_the_published_file(run_results):
    assert [s.clip_id for s in why(run_results, ["short.mp4"]).stories] == ["short"]


def test_of_several_names_the_good_ones_are_told(run_results):
    found = why(run_results, ["short", "smal", "small"])
    assert [s.clip_id for s in found.stories] == ["short", "small"]
    (problem,) = found.missed
    assert "clip 'smal'" in problem and "Near it: small" in problem


@pytest.fixture
def results_of(run_results, tmp_path):
    """A copy of the results, made by a run with these files and this --config."""

    def results_of(config=None, files=(), given=()):
        results = shutil.copytree(run_results, tmp_path / "of_run")
        remember(results, config or {}, files, given)
        return results

    return results_of


def test_what_to_do_is_right_for_the_run_at_hand(results_of):
    results = results_of(files=["my set.yaml"], given=["pathvars={results: my}"])
    again = "snakemake --cores 2 --configfile 'my set.yaml' --config 'pathvars={results: my}'"
    assert f"Set select.max_s to 12.7 in my set.yaml, then type again: {again}" in told(
        results, "-long"
    )
    lines = as_text(why(results, ["-long"])).splitlines()
    assert again in map(str.strip, lines)  # whole, to be copied
    forced = again.replace("--cores 2", "--cores 2 --forcerun fetch")
    assert told(results, "lost").endswith(f"into fetch.folder, then type: {forced}")


def test_a_key_of_the_command_line_is_changed_there(results_of):
    results = results_of(given=["select={max_s: 10, min_s: 5}"])
    changed = "snakemake --cores 2 --config 'select={max_s: 12.7, min_s: 5}'"
    assert f"Type this instead: {changed}" in told(results, "-long")


def test_a_clip_that_breaks_two_rules_is_told_what_to_do_about_both(results_of):
    results = results_of()
    path = results / "select" / "00" / "ledger.parquet"
    rows = tables.read(tables.LEDGER, path)
    rows.loc[rows["clip_id"] == "-long", "detail"] = "also a duplicate of good_0"
    tables.write(tables.LEDGER, rows, path)
    text = told(results, "-long")
    assert "Set select.max_s to 12.7 and select.max_overlap to null in config/config.yaml" in text
    assert "--set select.max_s=12.7 --set select.max_overlap=null" in text


def test_where_no_run_has_been_it_says_so(tmp_path):
    with pytest.raises(NoSuchFile, match="no such folder"):
        why(tmp_path / "results", ["a"])
    with pytest.raises(NoSuchFile, match="no ledger"):
        why(tmp_path, ["a"])


def test_a_stage_that_stopped_half_way_does_not_hide_the_others(run_results, tmp_path):
    shutil.copytree(run_results, tmp_path / "results")
    shutil.rmtree(tmp_path / "results" / "pose")
    assert "good_0: kept so far, by ingest" in told(tmp_path / "results", "good_0")


def test_shards_that_an_earlier_run_had_more_are_no_part_of_this_one(run_results, tmp_path):
    results = shutil.copytree(run_results, tmp_path / "again")
    for stage in ("catalogue", "select", "fetch"):
        shutil.copytree(results / stage / "00", results / stage / "01")
    assert told(results, "good_0") == told(run_results, "good_0").replace(
        str(run_results), str(results)
    )
    assert funnel(results, [], []).sound


def test_a_clip_that_stands_twice_in_a_table_is_told_as_such(run_results, tmp_path):
    results = shutil.copytree(run_results, tmp_path / "twice")
    shutil.copytree(results / "catalogue" / "00", results / "catalogue" / "01")
    (results / "catalogue" / "ledger.parquet").unlink()
    with pytest.raises(BadFile, match="catalogue, table clips: found clip '-long' twice"):
        why(results, ["good_0"])


def test_a_ledger_of_another_version_is_refused(run_results, tmp_path):
    results = shutil.copytree(run_results, tmp_path / "old")
    path = results / "pose" / "00" / "ledger.parquet"
    rows = tables.read(tables.LEDGER, path).assign(stage="posture")
    tables.write(tables.LEDGER, rows, path)
    with pytest.raises(BadFile, match="found the stage 'posture', expected catalogue, select"):
        why(results, ["good_0"])


def test_lines_fit_and_colour_changes_no_word(run_results):
    for asked in (["*"], ["looks_away"], ["turning", "-long"]):
        found = why(run_results, asked)
        plain = as_text(found)
        lines = [
            line for line in plain.splitlines() if not line.startswith(("  motion  ", "      "))
        ]
        assert "\x1b" not in plain and max(map(len, lines)) <= 100
        bare = as_text(found, colour=True)
        assert "\x1b[31m" in bare
        for code in ("0", "1", "2", "31", "32", "33"):
            bare = bare.replace(f"\x1b[{code}m", "")
        assert bare == plain


def test_a_program_gets_plain_values(run_results):
    (story,) = json.loads(as_json(why(run_results, ["looks_away"])))
    last = story["decisions"][-1]
    assert (last["stage"], last["rule"], last["first_frame"]) == ("pose", "turned", 60)
    assert last["value"] == pytest.approx(41.2) and last["limit"] == 35.0


def test_the_limit_that_is_offered_keeps_the_clip(run_results):
    rows = tables.read(tables.LEDGER, run_results / "select" / "00" / "ledger.parquet")
    for row in rows[rows["rule"].isin(["too_short", "too_long", "too_small"])].itertuples():
        if row.status == "dropped":
            step, _ = remedies.remedy("select", row.rule, row.value, None, run_results, Run({}))
            offered = float(step.say.split(" to ")[1].split(" ")[0])
            assert offered >= row.value if row.rule == "too_long" else offered <= row.value


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (["why", "short"], 0, "short: dropped by select"),
        (["why", "--", "-long", "short"], 0, "-long: dropped by select"),
        (["why", "-long", "short"], 0, "-long: dropped by select"),
        (["why", "short", "sort"], 1, "short: dropped by select"),
        (["why", "nobody_of_that_name"], 1, ""),
        (["why", "--json", "good"], 0, '"clip_id": "good_0"'),
        (["funnel"], 0, "10 clips in, 2 left after pose"),
        (["funnel", "--set", "select.min_s=3", "--config"], 0, "1 clip: short"),
    ],
)
def test_the_commands_say_it(run_results, tmp_path, monkeypatch, mimeline, arguments, code, told):
    if arguments[-1] == "--config":
        (tmp_path / "own.yaml").write_text(yaml.safe_dump({"select": OPTIONS}))
        arguments = [*arguments, str(tmp_path / "own.yaml")]
    monkeypatch.chdir(tmp_path)
    command, *rest = arguments
    said = mimeline(command, "--results", run_results, *rest)
    assert told in said.out and "\x1b" not in said.out
    assert said.code == code or "found no clip" in said.err


def test_why_without_a_name_asks_for_one(mimeline):
    said = mimeline("why", "--json")
    assert said.code == 2 and "why needs a clip's id" in said.err

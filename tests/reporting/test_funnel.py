import pandas as pd
import pytest

from mimeline.errors import BadFile
from mimeline.reporting import funnel as module
from mimeline.reporting.funnel import funnel
from mimeline.reporting.summary import lead


def kept(*clips: str) -> list[dict]:
    return [{"clip_id": clip, "status": "kept"} for clip in clips]


def lost(clip: str, status: str = "dropped", **facts) -> dict:
    return {"clip_id": clip, "status": status, "rule": "turned"} | facts


def test_clips_in_are_those_kept_dropped_and_failed(tmp_path, ledger):
    first = ledger(tmp_path / "a", "catalogue", [*kept("a", "b", "c"), lost("d", "failed")])
    second = ledger(tmp_path / "b", "select", [*kept("a"), lost("b"), lost("c")])
    stages = {stage.name: stage for stage in funnel([second, first]).stages}
    assert list(stages) == ["catalogue", "select"]
    assert (stages["catalogue"].entered, stages["catalogue"].failed) == (4, 1)
    assert (stages["select"].entered, stages["select"].dropped, stages["select"].kept) == (3, 2, 1)
    assert stages["select"].reasons == [("the head turns too far", 2)]


def test_a_single_lost_clip_is_spoken_of_as_one(tmp_path, ledger):
    parts = pd.DataFrame({"part": ["train"]})
    for n_lost, said in ((1, "the reason of the other stands"), (2, "of each of the other 2")):
        rows = [*kept("a"), *(lost(f"lost{n}") for n in range(n_lost))]
        way = funnel([ledger(tmp_path / str(n_lost), "catalogue", rows)])
        assert said in lead(way, parts, [], "")[0]


def test_a_clip_that_vanishes_between_two_stages_is_an_error(tmp_path, ledger):
    first = ledger(tmp_path / "a", "catalogue", kept("a", "b"))
    second = ledger(tmp_path / "b", "select", kept("a"))
    with pytest.raises(BadFile, match="clip 'b', which has no decision"):
        funnel([first, second])


def test_a_clip_that_comes_from_nowhere_is_an_error(tmp_path, ledger):
    first = ledger(tmp_path / "a", "catalogue", [*kept("a"), lost("b")])
    second = ledger(tmp_path / "b", "select", kept("a", "b"))
    with pytest.raises(BadFile, match="clip 'b', which never came in"):
        funnel([first, second])


def test_a_clip_that_is_kept_but_not_there_at_the_end_is_an_error(tmp_path, ledger):
    first = ledger(tmp_path / "a", "catalogue", kept("a", "b"))
    assert funnel([first], through={"a", "b"}).kept == 2
    with pytest.raises(BadFile, match="clip 'b' amiss"):
        funnel([first], through={"a"})


def test_a_stage_without_its_ledger_is_an_error(tmp_path, ledger):
    first = ledger(tmp_path / "a", "catalogue", kept("a"))
    with pytest.raises(BadFile, match="stage select: found clip 'a', which has no decision"):
        funnel([first, ledger(tmp_path / "c", "ingest", kept("a"))])


def test_where_no_clip_came_through_the_later_stages_are_shown_empty(tmp_path, ledger):
    way = funnel([ledger(tmp_path / "a", "catalogue", [lost("a")])], through=[])
    assert [stage.entered for stage in way.stages] == [1, 0, 0, 0, 0, 0]
    assert way.kept == 0


def test_a_clip_decided_on_in_two_shards_is_an_error(tmp_path, ledger):
    shards = [ledger(tmp_path / n, "select", kept("a")) for n in ("00", "01")]
    with pytest.raises(BadFile, match="'a' twice"):
        funnel([ledger(tmp_path / "c", "catalogue", kept("a")), *shards])


def test_a_value_is_told_against_its_limit_with_the_unit(tmp_path, ledger):
    facts = {"value": 41.26, "limit": 35.0, "unit": "deg", "first_frame": 12, "last_frame": 40}
    way = funnel([ledger(tmp_path / "a", "catalogue", [lost("a", **facts)])])
    loss = way.losses[0]
    assert (loss.value, loss.limit, loss.frames) == ("41.3°", "35°", "12–40")


def test_more_lost_clips_than_fit_are_counted(tmp_path, ledger, monkeypatch):
    monkeypatch.setattr(module, "MOST_ROWS", 2)
    way = funnel([ledger(tmp_path / "a", "catalogue", [lost(clip) for clip in "abcde"])])
    assert (len(way.losses), way.unlisted) == (2, 3)


def test_of_more_lost_clips_than_fit_those_of_every_stage_and_rule_are_listed(
    tmp_path, ledger, monkeypatch
):
    monkeypatch.setattr(module, "MOST_ROWS", 4)
    many = [lost(clip, rule="too_short") for clip in "abcdef"] + [lost("g", rule="too_long")]
    first = ledger(tmp_path / "a", "catalogue", kept(*"abcdefghi"))
    second = ledger(tmp_path / "b", "select", [*many, *kept("h", "i")])
    third = ledger(tmp_path / "c", "fetch", [lost("h", "failed", rule="gone"), *kept("i")])
    way = funnel([first, second, third])
    assert [loss.clip_id for loss in way.losses] == ["g", "a", "b", "h"]
    assert way.unlisted == 4


def test_kept_clips_with_the_same_note_share_a_line(tmp_path, ledger):
    note = {"rule": "too_small", "detail": "not applied: no size"}
    rows = [row | note for row in kept(*"abcdefgh")]
    notes = funnel([ledger(tmp_path / "a", "catalogue", rows)]).notes
    assert [(n.clips, n.text) for n in notes] == [
        (8, "rule “the face crop is too small” was not applied: no size")
    ]


def test_a_rule_that_some_frames_could_not_answer_is_not_said_to_be_broken(tmp_path, ledger):
    detail = "applied to the 10 of 300 frames with a loss"
    rows = [row | {"rule": "tracking_loss", "detail": detail} for row in kept("a")]
    (note,) = funnel([ledger(tmp_path / "a", "catalogue", rows)]).notes
    assert note.text.endswith("loss is too large” was applied to some frames only")
    assert note.example == detail


def test_a_clip_with_several_notes_is_one_clip_and_each_note_has_a_line(tmp_path, ledger):
    rows = [kept("a")[0] | {"rule": rule, "detail": rule[0]} for rule in ("masked", "frozen")]
    way = funnel([ledger(tmp_path / "a", "catalogue", [*rows, *kept("b")])])
    assert (way.entered, way.kept) == (2, 2)
    assert [(note.clips, note.example) for note in way.notes] == [(1, "m"), (1, "f")]


def test_a_note_beside_the_row_that_says_why_a_clip_is_gone_is_an_error(tmp_path, ledger):
    rows = [kept("a")[0] | {"rule": "masked"}, lost("a")]
    with pytest.raises(BadFile, match="clip 'a' twice"):
        funnel([ledger(tmp_path / "a", "catalogue", rows)])

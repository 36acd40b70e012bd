import json

import pytest

from mimeline.clips.catalogues.celebvhq import read
from mimeline.errors import BadFile

META = {"appearance_mapping": ["Blurry", "Male", "Young"], "action_mapping": ["blow", "Close eyes"]}


def record(appearance=(0, 1, 1), action=(0, 1), emotion=None, end=16.0, **more):
    emotion = {"sep_flag": False, "labels": "neutral"} if emotion is None else emotion
    return {
        "ytb_id": "M2Ohb0FAaJU",
        "duration": {"start_sec": 10.0, "end_sec": end},
        "bbox": {"top": 0.0, "bottom": 0.8815, "left": 0.1964, "right": 0.6922},
        "attributes": {"appearance": list(appearance), "action": list(action), "emotion": emotion},
        "version": "v0.1",
    } | more


@pytest.fixture
def catalogue(tmp_path):
    def catalogue(clips, meta=META):
        content = {"meta_info": meta, "clips": clips}
        (tmp_path / "info.json").write_text(json.dumps(content))
        rows, bad = read(tmp_path, "info.json")
        return {row["clip_id"]: row for row in rows}, dict(bad)

    return catalogue


def several(*labels):
    told = [{"emotion": e, "start_sec": since, "end_sec": until} for e, since, until in labels]
    return {"sep_flag": True, "labels": told}


def test_ones_become_the_names_that_they_stand_for(catalogue):
    rows, _ = catalogue({"a_0": record()})
    assert rows["a_0"]["attributes"] == ["male", "young"]
    assert [act["name"] for act in rows["a_0"]["actions"]] == ["close_eyes"]


def test_nobody_says_when_an_action_begins_so_it_holds_throughout(catalogue):
    rows, _ = catalogue({"a_0": record()})
    (act,) = rows["a_0"]["actions"]
    assert (act["start_s"], act["end_s"], act["uncertainty_s"]) == (0.0, 6.0, None)


def test_who_is_not_male_is_female_unless_nothing_is_told_of_the_looks(catalogue):
    rows, _ = catalogue({"a_0": record((0, 0, 1)), "b_0": record((0, 0, 0))})
    assert rows["a_0"]["attributes"] == ["female", "young"]
    assert rows["b_0"]["attributes"] == []


def test_emotions_keep_their_seconds_and_what_lies_between_stays_untold(catalogue):
    emotion = several(("neutral", 0, 0.28), ("happy", 1.28, 6.004))
    rows, _ = catalogue({"a_0": record(emotion=emotion)})
    assert [(e["name"], e["start_s"], e["end_s"]) for e in rows["a_0"]["emotions"]] == [
        ("neutral", 0.0, 0.28),
        ("happy", 1.28, 6.0),
    ]


def test_an_emotion_without_times_holds_throughout(catalogue):
    rows, _ = catalogue({"a_0": record()})
    (emotion,) = rows["a_0"]["emotions"]
    assert (emotion["name"], emotion["start_s"], emotion["end_s"]) == ("neutral", 0.0, 6.0)


def test_an_emotion_after_the_clip_is_left_out_and_told_of(catalogue):
    rows, _ = catalogue({"a_0": record(emotion=several(("happy", 1, 2), ("anger", 7, 8)))})
    assert [e["name"] for e in rows["a_0"]["emotions"]] == ["happy"]
    assert rows["a_0"]["notes"] == [
        ("outside_clip", {"value": 1, "unit": "intervals", "detail": "anger 7 to 8 s"})
    ]


@pytest.mark.parametrize(
    "bad",
    [
        record((0, 1)),
        record((0, 1, 2)),
        record((0, True, 1)),
        record((0, None, 1)),
        record(action=[{}, 1]),
        record(emotion=several(("happy", 3, 2))),
        record(emotion=several(("happy", "1", 2))),
        record(emotion={"labels": 5}),
        record(emotion={}),
        record(attributes=None),
        {k: v for k, v in record().items() if k != "attributes"},
        None,
    ],
)
def test_a_record_whose_attributes_do_not_fit_fails_alone(catalogue, bad):
    rows, failed = catalogue({"a_0": record(), "b_0": bad})
    assert list(rows) == ["a_0"]
    assert "info.json, record b_0: found" in str(failed["b_0"])


@pytest.mark.parametrize(
    "content",
    [
        {"clips": {}},
        {"meta_info": META},
        {"meta_info": META, "clips": []},
        {"meta_info": {"appearance_mapping": [1], "action_mapping": []}, "clips": {}},
        {"a_0.mp4": record()},
    ],
)
def test_a_file_without_its_names_is_no_such_catalogue(tmp_path, content):
    (tmp_path / "info.json").write_text(json.dumps(content))
    with pytest.raises(BadFile, match=r"info.json.*celebvhq_info.json as published"):
        read(tmp_path, "info.json")


def test_clips_that_stand_there_twice_are_not_passed_over(tmp_path):
    meta, clips = json.dumps(META), json.dumps({"a_0": record()})
    text = f'{{"meta_info": {meta}, "clips": {clips}, "clips": {{}}}}'
    (tmp_path / "info.json").write_text(text)
    with pytest.raises(BadFile, match="key 'clips' twice"):
        read(tmp_path, "info.json")

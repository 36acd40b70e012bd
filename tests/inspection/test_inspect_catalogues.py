import json
import pickle

import pytest

from mimeline.inspection import inspect, options


def record(start=10.0, end=16.0, **more):
    box = {"top": 0.0, "bottom": 0.9, "left": 0.2, "right": 0.8}
    return {"ytb_id": "x", "duration": {"start_sec": start, "end_sec": end}, "bbox": box} | more


def seen(path, content):
    path.write_text(json.dumps(content))
    return inspect(path, options())


@pytest.mark.parametrize(
    "wrapped", [lambda r: r, lambda r: {"clips": r}, lambda r: {"clips_set1": r}]
)
def test_celebv_text_is_known_in_all_its_shapes(tmp_path, wrapped):
    found = seen(tmp_path / "info.json", wrapped({"a_0.mp4": record(), "b_0": record(20, 30)}))
    assert (found.kind, found.sound) == ("CelebV-Text catalogue", True)
    assert found.facts["clips"] == "2, from 1 sources"
    assert found.facts["length"] == "6.0 to 10.0 s, 0.3 min in all"


def test_celebv_hq_is_known_and_told_what_it_holds(tmp_path):
    emotion = {"sep_flag": False, "labels": "happy"}
    told = {"appearance": [1], "action": [0], "emotion": emotion}
    meta = {"appearance_mapping": ["Male"], "action_mapping": ["nod"]}
    clips = {"a_0": record(attributes=told)}
    for content in ({"meta_info": meta, "clips": clips}, {"clips": clips, "meta_info": meta}):
        found = seen(tmp_path / "hq.json", content)
        assert (found.kind, found.sound) == ("CelebV-HQ catalogue", True)
        assert (found.facts["emotions"], found.facts["attributes"]) == ("of 1 clips", "of 1 clips")
        assert "actions" not in found.facts


def test_what_is_no_clip_is_told_before_a_run_is_spent_on_it(tmp_path):
    bad = {"../a": record(), "b_0": record(5, 3), "c_0": {}, "d_0": record()}
    found = seen(tmp_path / "info.json", bad)
    assert len(found.problems) == 3
    assert any("plain file name" in problem for problem in found.problems)
    assert found.numbers["clips"] == 1


def test_records_that_get_in_each_others_way_are_told(tmp_path):
    one = json.dumps(record())
    (tmp_path / "info.json").write_text(f'{{"a_0": {one}, "A_0": {one}, "a_0": {one}}}')
    found = inspect(tmp_path / "info.json", options())
    assert [problem.split(": ")[0] for problem in found.problems] == ["A_0", "a_0#2"]
    assert found.numbers["clips"] == 1


def test_of_many_bad_records_a_few_are_told(tmp_path):
    found = seen(tmp_path / "info.json", {f"a_{n}": {"ytb_id": 5} for n in range(2000)})
    assert len(found.problems) == 11
    assert found.problems[-1] == "and 1,990 more"


def test_annotations_are_known_pickled_or_not(tmp_path):
    told = {"act": {"a_0": [], "b_0": []}, "app": {"a_0": {}}}
    files = {f"{n}.pkl": pickle.dumps(told, protocol=n) for n in (2, 4, 5)}
    files |= {"told.json": json.dumps(told, indent=1).encode()}
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        found = inspect(tmp_path / name, options())
        assert (found.kind, found.sound) == ("CelebV-Text annotations", True)
        assert found.facts == {"act": "of 2 clips", "app": "of 1 clips"}

import json
import pickle

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mimeline import tables
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


CLIPS = {
    "clip_id": ["a", "a", "b", "../c"],
    "source_id": ["s", "s", "t", "u"],
    "end_s": [4.0, 5.0, 0.0, 1.0],
    "actions": ["nod", "", "", ""],
}


@pytest.mark.parametrize("file", ["clips.csv", "clips.parquet", "mine.parquet"])
def test_a_table_of_clips_is_read_as_a_run_would(tmp_path, file):
    if file.endswith(".csv"):
        lines = [",".join(map(str, row)) for row in (CLIPS, *zip(*CLIPS.values(), strict=True))]
        (tmp_path / file).write_text("\n".join(lines))
    else:
        pq.write_table(pa.table(CLIPS), tmp_path / file)
    found = inspect(tmp_path / file, options())
    assert (found.kind, found.facts["clips"]) == ("table of clips", "1, from 1 sources")
    assert found.facts["actions"] == "of 1 clips"
    assert sorted(problem.split(": ")[0] for problem in found.problems) == ["../c", "a#2", "b"]


def test_a_table_of_clips_with_a_misspelt_column_is_told_so(tmp_path):
    (tmp_path / "my.csv").write_text("clip_id,Video,start\na,x.mp4,1\n")
    found = inspect(tmp_path / "my.csv", options())
    assert found.kind == "table of clips" and "but Video" in found.error


def test_videos_of_a_table_lie_under_the_configuration_s_data(tmp_path):
    (tmp_path / "data" / "lists").mkdir(parents=True)
    path = tmp_path / "data" / "lists" / "clips.csv"
    path.write_text("clip_id,video\na,x.mp4\n")
    config = tmp_path / "own.yaml"
    config.write_text(f"data_dir: {tmp_path / 'data'}")
    (beside,), (under,) = (
        inspect(path, chosen).problems for chosen in (options(), options(config))
    )
    assert f"{tmp_path / 'data' / 'lists' / 'x.mp4'}: found no such file" in beside
    assert f"{tmp_path / 'data' / 'x.mp4'}: found no such file" in under


def test_a_run_s_own_table_of_clips_stays_one(tmp_path):
    tables.write(
        tables.CLIPS, tables.CLIPS.schema.empty_table().to_pandas(), tmp_path / "c.parquet"
    )
    assert inspect(tmp_path / "c.parquet", options()).kind == "table clips"


def test_a_list_of_exclusions_is_known_and_its_problems_told(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("clip_id,reason\na,occlusion\nb,occlusion\nc,wrong_crop\n")
    found = inspect(path, options())
    assert (found.kind, found.sound) == ("list of exclusions", True)
    assert found.facts == {"clips": "3", "reasons": "occlusion 2, wrong_crop 1"}
    path.write_text("clip_id,reason\na,glasses, and a mask\n")
    assert "line 2: found 3 cells" in inspect(path, options()).error


def test_a_folder_says_which_of_its_files_are_lists(tmp_path):
    (tmp_path / "clips.csv").write_text("clip_id,source_id,end_s\na,s,1\n")
    (tmp_path / "out.csv").write_text("clip_id,reason\na,occlusion\n")
    rows = inspect(tmp_path, options()).rows
    assert rows[1:] == [("clips.csv", "table of clips"), ("out.csv", "list of exclusions")]

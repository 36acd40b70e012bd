"""Whatever stands in the files: an error that says so, or a row of the ledger for every record."""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.clips.catalogue import catalogue
from mimeline.errors import MimelineError

numbers = st.one_of(
    st.integers(-5, 3000),
    st.floats(),
    st.sampled_from([10**400, -1, 1e308, 0.5, True]),
)
texts = st.one_of(
    st.text(max_size=8),
    st.sampled_from(
        ["..", "../x", "a\x00b", "CON", "nul.mp4", "a.", "-x", "a/b", "\ud800", "0:0:9"]
    ),
)
anything = st.recursive(
    st.one_of(st.none(), numbers, texts),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(texts, inner, max_size=3)),
    max_leaves=8,
)
keys = st.one_of(
    st.sampled_from(["a_0", "b_0.mp4", "-c_0", "A_0", "a_0.mp4", "_c_0", "a_0_2", "a_0#2"]), texts
)
PLACES = [
    ["ytb_id"],
    ["duration"],
    ["duration", "start_sec"],
    ["duration", "end_sec"],
    ["bbox"],
    ["bbox", "left"],
    ["bbox", "bottom"],
    ["attributes"],
    ["attributes", "appearance"],
    ["attributes", "emotion"],
    ["attributes", "emotion", "labels"],
]


@st.composite
def records(draw):
    """A record, every third one with something else in one place, or with nothing there."""
    start = draw(st.sampled_from([0, 9.5, 55]))
    record = {
        "ytb_id": draw(st.sampled_from(["abc", "-abc", "ABC"])),
        "duration": {"start_sec": start, "end_sec": start + draw(st.sampled_from([3, 8.5]))},
        "bbox": {
            "top": 0.0,
            "bottom": 0.9,
            "left": 0.1,
            "right": draw(st.sampled_from([0.8, 1.02])),
        },
        "attributes": {
            "appearance": draw(st.sampled_from([[0, 1], [0, 0]])),
            "action": [1],
            "emotion": {"labels": [{"emotion": "happy", "start_sec": 0, "end_sec": 1.5}]},
        },
    }
    if draw(st.integers(0, 2)) == 0:
        *way, last = draw(st.sampled_from(PLACES))
        place = record
        for step in way:
            place = place[step]
        if draw(st.booleans()):
            place[last] = draw(anything)
        else:
            del place[last]
    return record


def mostly(right):
    return st.integers(0, 4).flatmap(lambda n: right if n else anything)


time = st.sampled_from(["0:0:9", "0:00:12", "0:1:0", "1:99:59.5"])
action = st.tuples(
    mostly(st.sampled_from(["nod", "Shake head"])), st.tuples(time, time).map(sorted)
)
actions = mostly(st.lists(action.map(list), max_size=3))
values = mostly(st.sampled_from([[""], ["left cheek"], [["frontal", ["0:0:0", "0:2:0", 120]]]]))
looks = mostly(st.dictionaries(st.sampled_from(["mole", "lighting"]), values, max_size=2))


@st.composite
def objects(draw, values):
    """The text of a JSON object whose keys may stand twice."""
    pairs = draw(st.lists(st.tuples(keys, values), max_size=5))
    inner = ", ".join(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in pairs)
    return f"{{{inner}}}", pairs


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("hostile")


def run(place: Path, format: str, options: dict, cut_s: float | None):
    """The ledger and the clips of a run; None where it refuses the files by an error of its own."""
    results = place / "results"
    results.mkdir(exist_ok=True)
    out, ledger = results / "clips.parquet", results / "ledger.parquet"
    try:
        catalogue(place / "data", [out], ledger, format, options, cut_s, None, None)
    except MimelineError:
        return None
    return tables.read(tables.LEDGER, ledger), tables.read(tables.CLIPS, out)


def everything_below(place: Path) -> set[str]:
    return {str(path) for path in place.rglob("*") if not path.is_dir()}


quickly = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@quickly
@given(info=objects(records()), act=objects(actions), app=objects(looks))
def test_no_celebvtext_catalogue_loses_a_record_or_writes_elsewhere(place, info, act, app):
    data = place / "data"
    data.mkdir(exist_ok=True)
    (data / "info.json").write_text(info[0])
    (data / "told.json").write_text(f'{{"act": {act[0]}, "app": {app[0]}}}')
    found = run(place, "celebvtext", {"info": "info.json", "annotations": "told.json"}, None)
    files = {"data/info.json", "data/told.json", "results/clips.parquet", "results/ledger.parquet"}
    assert everything_below(place) <= {str(place / name) for name in files}
    ledger, clips = found
    assert ledger["clip_id"].nunique() == len(info[1])
    assert set(clips["clip_id"]) == set(ledger.loc[ledger["status"] == "kept", "clip_id"])


@quickly
@given(info=objects(records()))
def test_no_celebvhq_catalogue_loses_a_record(place, info):
    data = place / "data"
    data.mkdir(exist_ok=True)
    names = '"meta_info": {"appearance_mapping": ["Male", "Young"], "action_mapping": ["nod"]}'
    (data / "info.json").write_text(f'{{{names}, "clips": {info[0]}}}')
    ledger, clips = run(place, "celebvhq", {"info": "info.json"}, None)
    assert ledger["clip_id"].nunique() == len(info[1])
    assert set(clips["clip_id"]) <= set(ledger["clip_id"])


@settings(max_examples=60, deadline=None)
@given(content=st.one_of(st.binary(max_size=60), anything.map(lambda a: json.dumps(a).encode())))
def test_any_file_is_a_catalogue_or_says_what_it_is(place, content):
    data = place / "data"
    data.mkdir(exist_ok=True)
    (data / "info.json").write_bytes(content)
    run(place, "celebvtext", {"info": "info.json", "annotations": None}, 10.0)
    run(place, "celebvhq", {"info": "info.json"}, 10.0)
    (data / "info.json").rename(data / "told.pkl")
    (data / "info.json").write_text("{}")
    run(place, "celebvtext", {"info": "info.json", "annotations": "told.pkl"}, None)
    (data / "told.pkl").unlink()

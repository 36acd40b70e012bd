import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.clips.conditions import condition
from mimeline.clips.select import decide, select
from mimeline.errors import BadConfig
from mimeline.ledger import Ledger

KEYS = {
    "min_s": 5.0,
    "max_s": 10.0,
    "min_side_px": 512,
    "excluded_actions": ["turn", "shake_head"],
    "exclusions": None,
    "conditions": [],
    "max_overlap": 0.5,
}


def table(rows: list[dict]) -> pd.DataFrame:
    defaults = {"start_s": 0.0, "end_s": 6.0, "width": 600, "height": 600, "actions": []}
    rows = [defaults | {"source_id": f"source of {row['clip_id']}"} | row for row in rows]
    clips = pd.DataFrame(rows, columns=tables.CLIPS.schema.names).assign(shard=0)
    clips["emotions"] = clips["attributes"] = clips["texts"] = [[]] * len(clips)
    return clips


@pytest.fixture
def run(tmp_path):
    def run(rows, **keys):
        tables.write(tables.CLIPS, table(rows), tmp_path / "in.parquet")
        out = tmp_path / "out.parquet", tmp_path / "ledger.parquet"
        select(tmp_path / "in.parquet", *out, **KEYS | keys)
        rows = tables.read(tables.LEDGER, out[1]).set_index("clip_id")
        return set(tables.read(tables.CLIPS, out[0])["clip_id"]), rows

    return run


def test_limits_of_length_are_inclusive(run):
    lengths = {"short": 4.99, "least": 5.0, "most": 10.0, "long": 10.01}
    kept, ledger = run(
        [{"clip_id": n, "start_s": 58.07, "end_s": 58.07 + s} for n, s in lengths.items()]
    )
    assert kept == {"least", "most"}
    assert ledger.loc["short", ["rule", "limit", "unit"]].tolist() == ["too_short", 5.0, "s"]
    assert ledger.loc["long", "value"] == pytest.approx(10.01)


def test_a_small_crop_is_dropped_and_an_unknown_size_is_noted(run):
    kept, ledger = run(
        [
            {"clip_id": "small", "width": 511},
            {"clip_id": "large"},
            {"clip_id": "unknown", "width": None, "height": None},
        ]
    )
    assert kept == {"large", "unknown"}
    assert ledger.loc["small", "value"] == 511
    assert ledger.loc["unknown", "detail"].startswith("not applied")


def test_clips_left_out_by_hand_keep_the_reason(run, tmp_path):
    path = tmp_path / "exclusions.csv"
    path.write_text("clip_id,reason\na,sunglasses\nc.mp4,mask\nd.mp4,\n")
    kept, ledger = run([{"clip_id": i} for i in ("a", "b", "c", "d.mp4")], exclusions=str(path))
    assert kept == {"b"}
    assert ledger.loc[["a", "c"], "detail"].tolist() == ["sunglasses", "mask"]


@pytest.mark.parametrize("name", ["head_wagging", "head wagging"])
def test_an_unwanted_action_drops_a_clip_however_its_name_is_spelt(run, name):
    acts = {"a": name, "b": "talk", "c": "head_wag"}
    rows = [
        {"clip_id": clip, "actions": [{"name": act, "start_s": 0.0, "end_s": 1.0}]}
        for clip, act in acts.items()
    ]
    for unwanted in ("head_wagging", "head wagging"):
        kept, ledger = run(rows, excluded_actions=[unwanted])
        assert kept == {"b", "c"}
        assert ledger.loc["a", "detail"] == f"{name} 0–1 s"


@pytest.mark.parametrize(
    ("start_s", "end_s", "uncertainty_s", "told"),
    [
        (2.0, 3.0, 0.0, "turn 2–3 s"),
        (0.0, 0.0, 1.0, "turn 0–0 s ± 1"),  # up to a second before the clip
        (6.0, 6.0, 1.0, "turn 6–6 s ± 1"),
        (0.0, 6.0, None, "turn 0–6 s"),
        (None, None, None, "turn"),
    ],
)
def test_an_action_drops_a_clip_be_it_ever_so_short(run, start_s, end_s, uncertainty_s, told):
    act = {"name": "turn", "start_s": start_s, "end_s": end_s, "uncertainty_s": uncertainty_s}
    kept, ledger = run([{"clip_id": "a", "actions": [act]}])
    assert not kept and ledger.loc["a", "detail"] == told


def test_a_clip_has_the_first_rule_that_it_breaks(run, tmp_path):
    path = tmp_path / "exclusions.csv"
    path.write_text("clip_id,reason\na,occlusion\n")
    worst = {
        "end_s": 3.0,
        "width": 100,
        "source_id": "s",
        "actions": [{"name": "turn", "start_s": 0.0, "end_s": 1.0}],
    }
    rows = [
        worst | {"clip_id": "a"},
        worst | {"clip_id": "b"},
        worst | {"clip_id": "c", "end_s": 6.0},
        worst | {"clip_id": "d", "end_s": 6.0, "actions": []},
        worst | {"clip_id": "e", "end_s": 6.0, "actions": [], "width": 600},
        {"clip_id": "f", "source_id": "s", "emotion": "sad"},
        {"clip_id": "g", "source_id": "s", "emotion": "sad"},
    ]
    kept, ledger = run(rows, exclusions=str(path), conditions=["emotion is not None"])
    assert kept == {"f"}
    assert ledger["rule"].drop("f").to_dict() == {
        "a": "excluded",
        "b": "too_short",
        "c": "excluded_action",
        "d": "too_small",
        "e": "condition",
        "g": "duplicate",
    }


def test_a_condition_drops_notes_what_it_cannot_tell_and_says_why(run):
    rows = [
        {"clip_id": "a", "emotion": "happy"},
        {"clip_id": "b", "emotion": "sad"},
        {"clip_id": "c"},
        {"clip_id": "d", "width": None, "height": None},
    ]
    wishes = ["emotion == 'happy'", "side_px > 550"]
    kept, ledger = run(rows, conditions=wishes)
    assert kept == {"a", "c", "d"}
    assert ledger.loc["b", "detail"] == "emotion == 'happy': emotion sad"
    assert pd.isna(ledger.loc["a", "rule"])
    wanting = "not applied: emotion == 'happy': the catalogue does not give emotion"
    assert ledger.loc["c", "detail"] == wanting
    noted = ledger.loc["d"].set_index("rule")["detail"]
    assert noted["condition"].startswith(f"{wanting}; not applied: side_px > 550: ")
    assert noted["too_small"].startswith("not applied")


def test_a_bad_condition_ends_the_stage_before_anything_is_written(run, tmp_path):
    with pytest.raises(BadConfig, match="which is no column"):
        run([{"clip_id": "a"}], conditions=["emoton == 'happy'"])
    assert [path.name for path in tmp_path.iterdir()] == ["in.parquet"]


def test_a_duplicate_of_a_clip_that_goes_itself_stays(run, tmp_path):
    path = tmp_path / "exclusions.csv"
    path.write_text("clip_id,reason\na,wrong_crop\n")
    rows = [{"clip_id": name, "source_id": "s"} for name in "abc"]
    kept, ledger = run(rows, exclusions=str(path))
    assert kept == {"b"}
    assert ledger.loc["c", ["rule", "value", "limit"]].tolist() == ["duplicate", 1.0, 0.5]
    assert ledger.loc["c", "detail"] == "b stays"
    assert run(rows, max_overlap=None)[0] == {"a", "b", "c"}


def test_a_duplicate_that_is_too_long_is_told_as_both(run):
    rows = [{"clip_id": name, "source_id": "s", "end_s": 18.2} for name in "ab"]
    kept, ledger = run(rows)
    assert not kept and set(ledger["rule"]) == {"too_long"}
    assert ledger.loc["b", "detail"] == "also a duplicate of a" and pd.isna(
        ledger.loc["a", "detail"]
    )


def test_ids_that_nobody_has_are_named_in_the_log(run, tmp_path, caplog):
    path, ledger = tmp_path / "exclusions.csv", tmp_path / "catalogue.parquet"
    path.write_text(
        "clip_id,reason\na,mask\nx1,mask\nb.mp4,mask\n" + "".join(f"y{n},\n" for n in "123456")
    )
    catalogue = Ledger("catalogue", ["a", "b"])
    catalogue.close(ledger, ["a", "b"])
    keys = {"exclusions": str(path), "catalogue": ledger}
    run([{"clip_id": "a"}], **keys)
    assert "ids that no clip has: 7 (x1, y1, y2, y3, y4, …)" in caplog.text
    caplog.clear()
    run([{"clip_id": "a"}], exclusions=str(path))
    assert "no clip has" not in caplog.text


NAMES = st.sampled_from(["turn", "talk", "smile"])
SECONDS = st.none() | st.floats(-3, 15, allow_nan=False)
ACTS = st.builds(
    lambda name, a, b, u: {"name": name, "start_s": a, "end_s": b, "uncertainty_s": u},
    *(NAMES, SECONDS, SECONDS, st.sampled_from([None, 0.0, 1.0])),
)
PIXELS = st.none() | st.integers(1, 2000)
CLIP = st.fixed_dictionaries(
    {
        "source_id": st.sampled_from(["s", "t"]),
        "start_s": st.floats(0, 20),
        "length": st.floats(0.1, 20),
        "width": PIXELS,
        "height": PIXELS,
        "emotion": st.sampled_from([None, "happy", "sad"]),
        "actions": st.lists(ACTS, max_size=3),
    }
)
WISHES = ["emotion == 'happy'", "'talk' in actions or side_px > 700", "duration_s < 9"]


@settings(max_examples=25, deadline=None)
@given(st.lists(CLIP, max_size=8), st.lists(st.sampled_from(WISHES), max_size=3), st.data())
def test_clips_in_are_clips_kept_and_clips_dropped_once_each(tmp_path_factory, rows, wishes, data):
    folder = tmp_path_factory.mktemp("any")
    rows = [row | {"clip_id": f"c{n}"} for n, row in enumerate(rows)]
    rows = [row | {"end_s": row["start_s"] + row.pop("length")} for row in rows]
    tables.write(tables.CLIPS, table(rows), folder / "in.parquet")
    known = tables.read(tables.CLIPS, folder / "in.parquet")
    by_hand = data.draw(st.dictionaries(st.sampled_from(["c0", "c3", "x"]), st.text(), max_size=3))
    found = decide(
        known,
        min_s=5.0,
        max_s=10.0,
        min_side_px=512,
        excluded_actions=["turn"],
        conditions=[condition(wish) for wish in wishes],
        max_overlap=data.draw(st.none() | st.floats(0, 1)),
        exclusions=by_hand,
    )
    dropped, noted = (found[found["status"] == status] for status in ("dropped", "kept"))
    assert dropped["clip_id"].is_unique and dropped["rule"].notna().all()
    assert not set(dropped["clip_id"]) & set(noted["clip_id"])
    assert set(found["clip_id"]) <= set(known["clip_id"])
    assert not noted.duplicated(["clip_id", "rule"]).any()


def test_a_shard_without_clips_is_selected_from(run):
    kept, ledger = run([], conditions=["emotion == 'happy'", "'talk' in actions"])
    assert not kept and ledger.empty

import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.select import read_exclusions, select
from mimeline.errors import BadFile, MissingColumn

KEYS = {
    "min_s": 5.0,
    "max_s": 10.0,
    "min_side_px": 512,
    "excluded_actions": ["turn", "shake_head"],
    "exclusions": None,
}


def table(rows: list[dict]) -> pd.DataFrame:
    defaults = {"source_id": "s", "start_s": 0.0, "end_s": 6.0, "width": 600, "height": 600}
    rows = [defaults | {"actions": []} | row for row in rows]
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


def test_an_unwanted_action_drops_a_clip(run):
    turn = [{"name": "turn", "start_s": 0.0, "end_s": 1.0}]
    talk = [{"name": "talk", "start_s": 0.0, "end_s": 1.0}]
    kept, ledger = run([{"clip_id": "a", "actions": turn}, {"clip_id": "b", "actions": talk}])
    assert kept == {"b"}
    assert ledger.loc["a", "detail"] == "turn"


def test_clips_left_out_by_hand_keep_the_reason(run, tmp_path):
    path = tmp_path / "exclusions.csv"
    path.write_text("clip_id,reason\na,sunglasses\n")
    kept, ledger = run([{"clip_id": "a"}, {"clip_id": "b"}], exclusions=str(path))
    assert kept == {"b"}
    assert ledger.loc["a", "detail"] == "sunglasses"


def test_a_list_of_exclusions_that_is_none_says_so(tmp_path):
    with pytest.raises(BadFile, match="no such file"):
        read_exclusions(str(tmp_path / "none.csv"))
    (tmp_path / "bad.csv").write_text("clip\na\n")
    with pytest.raises(MissingColumn, match="clip_id, reason"):
        read_exclusions(str(tmp_path / "bad.csv"))

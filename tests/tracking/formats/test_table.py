import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from mimeline.errors import BadFile, MimelineError, MissingColumn
from mimeline.tracking.formats import table
from mimeline.tracking.loss import broken, with_loss
from mimeline.tracking.take import assemble
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

PLAIN = {
    "bad_values": "fail",
    "fps": "30",
    "channels": {},
    "angle_unit": "radians",
    "frame": None,
    "first_frame": 0,
    "valid": None,
    "confidence": None,
    "loss": None,
}
OURS = PLAIN | {
    "frame": "frame",
    "valid": "valid",
    "confidence": "confidence",
    "loss": "tracker_loss",
}


def column(name: str, scale: float = 1.0) -> dict:
    return {"column": name, "scale": scale}


@pytest.fixture(params=["csv", "parquet"])
def read(request, tmp_path):
    """Reads rows that were written as CSV, then as Parquet."""

    def of(rows: pd.DataFrame, **options):
        path = tmp_path / f"take.{request.param}"
        if request.param == "csv":
            rows.to_csv(path, index=False)
        else:
            rows.to_parquet(path, index=False)
        return table.read(path, **PLAIN | options)

    return of


def rows(**columns) -> pd.DataFrame:
    return pd.DataFrame({"jawOpen": [0.1, 0.2, 0.3], "browDown_L": [0.4, 0.5, 0.6]} | columns)


def test_columns_of_a_channels_name_are_taken_without_a_mapping(read):
    take = read(rows(speaker=["a", "b", "c"]))
    np.testing.assert_allclose(take.motion["jawOpen"], [0.1, 0.2, 0.3], rtol=1e-6)
    np.testing.assert_allclose(take.motion["browDownLeft"], [0.4, 0.5, 0.6], rtol=1e-6)
    assert take.motion["browDownRight"].isna().all()
    assert take.origins["browDownLeft"].text == "column browDown_L"
    assert take.first_frame is None and not take.numbered and take.loss == ""


def test_mapped_columns_are_scaled(read):
    mapping = {"mouthSmileLeft": column("smile_l", 0.01), "head_yaw_left": column("yaw", -1)}
    take = read(
        rows(smile_l=[0, 50, 100], yaw=[0, 30, -30]), channels=mapping, angle_unit="degrees"
    )
    np.testing.assert_allclose(take.motion["mouthSmileLeft"], [0, 0.5, 1], rtol=1e-6)
    np.testing.assert_allclose(take.motion["head_yaw_left"], np.radians([0, -30, 30]), rtol=1e-6)
    assert take.origins["mouthSmileLeft"].text == "column smile_l x 0.01"


def test_a_table_of_foreign_names_alone_is_read_by_its_mapping(read):
    foreign = pd.DataFrame({"smile": [0.1, 0.2]})
    both = {name: column("smile") for name in ("mouthSmileLeft", "mouthSmileRight")}
    motion = read(foreign, channels=both).motion
    assert (motion["mouthSmileLeft"] == motion["mouthSmileRight"]).all()


def test_sides_may_be_exchanged_by_the_mapping(read):
    sides = pd.DataFrame({"eyeBlinkLeft": [0.1], "eyeBlinkRight": [0.9]})
    swapped = {"eyeBlinkLeft": column("eyeBlinkRight"), "eyeBlinkRight": column("eyeBlinkLeft")}
    motion = read(sides, channels=swapped).motion
    assert motion["eyeBlinkLeft"].iloc[0] == pytest.approx(0.9)
    assert motion["eyeBlinkRight"].iloc[0] == pytest.approx(0.1)


def test_a_channel_that_is_told_twice_is_refused(read):
    with pytest.raises(BadFile, match="column jawOpen.*takes from jaw.*once"):
        read(rows(jaw=1.0), channels={"jawOpen": column("jaw")})
    with pytest.raises(BadFile, match="column jawOpen twice"):
        read(rows(JawOpen=1.0))


@pytest.mark.parametrize(
    "options",
    [
        {"channels": {"mouthSmileLeft": column("smile_l")}},
        {"frame": "number"},
        {"valid": "ok"},
        {"confidence": "sure"},
        {"loss": "energy"},
    ],
)
def test_a_column_that_the_configuration_names_must_be_there(read, options):
    with pytest.raises(MissingColumn, match="smile_l|number|ok|sure|energy"):
        read(rows(), **options)


def test_a_mapping_to_no_column_says_which_and_what_there_is(read):
    more = {f"other_{number}": [0, 0, 0] for number in range(20)}
    expected = r"no column LSmile; the file has jawOpen, .*other_9, ….*channels\.mouthSmileLeft"
    with pytest.raises(MissingColumn, match=expected):
        read(rows(**more), channels={"mouthSmileLeft": column("LSmile")})


def test_a_table_without_a_channel_or_without_a_row_is_refused(read):
    with pytest.raises(BadFile, match="found time, smile.*Name its columns under ingest.table.ch"):
        read(pd.DataFrame({"time": [0.0], "smile": [1.0]}))
    with pytest.raises(BadFile):
        read(rows().head(0))


def test_a_table_without_a_header_is_refused(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("0.1,0.2,0.3\n0.2,0.3,0.4\n")
    with pytest.raises(BadFile, match="header"):
        table.read(path, **PLAIN)


def test_frames_are_counted_from_the_configured_first_one(read):
    take = read(rows(number=[12, 10, 13]), frame="number", first_frame=10)
    assert take.motion["valid"].tolist() == [True, False, True, True]
    np.testing.assert_allclose(take.motion["jawOpen"], [0.2, np.nan, 0.1, 0.3], rtol=1e-6)
    assert take.first_frame == 10 and take.numbered


@pytest.mark.parametrize("number", [[1, 1, 2], [0, 0.5, 1], [-1, 0, 1], [0, 1, 3e9]])
def test_frames_that_are_no_count_are_refused(read, number):
    with pytest.raises(BadFile, match="column number|frames in a take"):
        read(rows(number=number), frame="number")


def test_a_column_of_frames_that_is_not_counted_by_must_count_the_rows(read):
    assert read(rows(frame=[7, 8, 9])).motion["valid"].all()
    assert read(rows(frame=[7, None, 9])).motion["valid"].all()
    for name, told, found in [
        ("frame", [0, 2, 3], "2 in row 2"),
        ("Frame", [0, 1, 3], "3 in row 3"),
        ("frame", [0, None, 3], "3 in row 3"),
    ]:
        with pytest.raises(BadFile, match=f"column {name}: found {found}.*ingest.table.frame"):
            read(rows(**{name: told}))


def test_a_column_of_frames_that_tells_no_number_counts_no_rows(tmp_path):
    path = tmp_path / "take.csv"
    rows(frame=["1.png", "2.png", "4.png"]).to_csv(path, index=False)
    with pytest.raises(BadFile, match="column frame: found 1.png in row 1.*take the column out"):
        table.read(path, **PLAIN)


@pytest.mark.parametrize("ok", [[1, 0, 1], [True, False, True], [0.9, 0.0, 1.0], [1, None, 1]])
def test_a_frame_without_a_face_is_not_valid(read, ok):
    take = read(rows(ok=ok), valid="ok")
    assert take.motion["valid"].tolist() == [True, False, True]
    assert take.motion.loc[1, list(CHANNELS)].isna().all()


def test_what_a_lost_frame_holds_is_not_looked_at(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("jawOpen,ok\n0.1,yes\n0.2,1\n")
    with pytest.raises(BadFile, match="line 2, column ok"):
        table.read(path, **PLAIN | {"valid": "ok"})
    path.write_text("jawOpen,ok\nlost,false\n0.2,TRUE\n")
    assert table.read(path, **PLAIN | {"valid": "ok"}).motion["valid"].tolist() == [False, True]


def test_empty_cells_are_not_given_and_empty_rows_not_valid(read):
    motion = read(
        pd.DataFrame({"jawOpen": [0.1, None, None], "cheekPuff": [0.2, 0.3, None]})
    ).motion
    assert motion["valid"].tolist() == [True, True, False]
    assert motion["jawOpen"].isna().tolist() == [False, True, True]


def test_text_in_a_number_is_named_or_masks_its_frame(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("jawOpen,cheekPuff\n0.1,0.1\nwide,0.1\n")
    with pytest.raises(BadFile, match="line 3, column jawOpen.*'wide'"):
        table.read(path, **PLAIN)
    motion = table.read(path, **PLAIN | {"bad_values": "mask"}).motion
    assert motion["valid"].tolist() == [True, False]


def test_confidence_and_loss_come_from_their_columns(read):
    take = read(rows(sure=[0.9, 0.8, 0.7], energy=[3, 2, 1]), confidence="sure", loss="energy")
    assert take.motion["confidence"].tolist() == [0.9, 0.8, 0.7]
    assert take.motion["tracker_loss"].tolist() == [3, 2, 1]
    assert take.loss == "column energy"


def test_a_loss_that_came_to_nothing_is_infinite_as_in_a_sidecar(tmp_path):
    losses = ["0.5", "nan", "inf", "", " NaN", "-inf"]
    inside, beside = tmp_path / "inside.csv", tmp_path / "beside.csv"
    told = pd.DataFrame({"frame": range(6), "jawOpen": np.linspace(0, 1, 6), "loss": losses})
    told.to_csv(inside, index=False)
    told[["frame", "jawOpen"]].to_csv(beside, index=False)
    told[["frame", "loss"]].to_csv(tmp_path / "beside.loss.csv", index=False)
    sidecar = with_loss(table.read(beside, **PLAIN), beside, None).motion["tracker_loss"]
    for bad_values in ("mask", "fail"):
        options = PLAIN | {"loss": "loss", "bad_values": bad_values}
        take = table.read(inside, **options)
        assert take.motion["valid"].all()
        np.testing.assert_array_equal(take.motion["tracker_loss"], sidecar)
        facts = broken(take, max_loss=1.0, max_reprojection=None)
        assert (facts["first_frame"], facts["value"]) == (1, np.inf)


def test_a_loss_that_is_no_number_is_named_or_infinite(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("jawOpen,loss\n0.1,0.2\n0.2,high\n")
    with pytest.raises(BadFile, match="line 3, column loss.*'high'"):
        table.read(path, **PLAIN | {"loss": "loss"})
    masked = table.read(path, **PLAIN | {"loss": "loss", "bad_values": "mask"})
    assert masked.motion["tracker_loss"].tolist() == [0.2, np.inf]


def test_a_parquets_null_is_no_loss_and_its_nan_an_infinite_one(tmp_path):
    path = tmp_path / "take.parquet"
    losses = pa.array([0.5, None, np.nan, np.inf], from_pandas=False)
    pq.write_table(pa.table({"jawOpen": [0.1, 0.2, 0.3, 0.4], "loss": losses}), path)
    told = table.read(path, **PLAIN | {"loss": "loss"}).motion["tracker_loss"]
    np.testing.assert_array_equal(told, [0.5, np.nan, np.inf, np.inf])


def test_values_far_out_of_range_are_refused_with_what_to_set(read):
    found = r"(line 3|row 2), column puff: found 30, .*between 0 and 1.*cheekPuff: .*scale: 0.01"
    with pytest.raises(BadFile, match=found):
        read(rows(puff=[0, 30, 100]), channels={"cheekPuff": column("puff")})
    found = "(line 3|row 2), column gaze_up: found 10, an angle of 573 degrees.*table.angle_unit"
    with pytest.raises(BadFile, match=found):
        read(rows(gaze_up=[0, 10, 20]))


@pytest.mark.parametrize(
    "values", [pa.array(["a"] * 2), pa.array([[1.0]] * 2), pa.array([{"x": 1.0}] * 2)]
)
def test_a_parquet_column_that_holds_no_numbers_is_refused(tmp_path, values):
    path = tmp_path / "take.parquet"
    pq.write_table(pa.table({"jawOpen": values}), path)
    with pytest.raises(BadFile, match="column jawOpen.*numbers"):
        table.read(path, **PLAIN)


@settings(max_examples=40, deadline=None)
@given(at=st.integers(0, 900), byte=st.integers(0, 255), cut=st.booleans())
def test_a_broken_parquet_file_gives_a_take_or_our_error(tmp_path_factory, at, byte, cut):
    path = tmp_path_factory.getbasetemp() / "broken.parquet"
    rows().to_parquet(path, index=False)
    content = bytearray(path.read_bytes())
    at %= len(content)
    content[at] = byte
    path.write_bytes(content[:at] if cut else content)
    table.holds(path)
    try:
        table.read(path, **PLAIN)
    except MimelineError as error:
        assert str(path) in str(error)


def test_only_tables_of_no_other_format_are_held_for_it(tmp_path):
    for name, header, is_its_own in [
        ("plain", "frame,jawOpen", True),
        ("livelink", "Timecode,BlendShapeCount,JawOpen", False),
        ("pyfeat", "FaceScore,jawOpen", False),
        ("mediapipe", "_neutral,jawOpen", False),
        ("nothing", "a,b", False),
    ]:
        (tmp_path / f"{name}.csv").write_text(header + "\n0,0\n")
        assert table.holds(tmp_path / f"{name}.csv") == is_its_own
    rows().to_parquet(tmp_path / "take.parquet")
    (tmp_path / "other.parquet").write_bytes(b"PAR1")
    assert table.holds(tmp_path / "take.parquet")
    assert not table.holds(tmp_path / "other.parquet")
    assert not table.holds(tmp_path / "none.parquet")


@st.composite
def motions(draw) -> pd.DataFrame:
    """What a take's motion may be: measured channels, gaps, NaN where nothing was told."""
    n_frames = draw(st.integers(1, 6))
    names = draw(st.lists(st.sampled_from(list(CHANNELS)), min_size=1, max_size=6, unique=True))

    def numbers(low: float, high: float, width: int = 32) -> np.ndarray:
        elements = st.floats(low, high, width=width) | st.just(np.nan)
        return draw(hnp.arrays(f"float{width}", n_frames, elements=elements))

    channels = pd.DataFrame(
        {name: numbers(-1, 2) if name in EXPRESSIONS else numbers(-3, 3) for name in names}
    )
    told = draw(hnp.arrays(bool, n_frames)) & channels.notna().any(axis=1).to_numpy()
    motion = assemble(np.arange(n_frames), told, channels, numbers(0, 1, 64), None)
    return motion.assign(tracker_loss=numbers(0, 1e6, 64))


@settings(max_examples=30, deadline=None)
@given(motion=motions().filter(lambda m: m[list(CHANNELS)].notna().any(axis=None)))
def test_what_is_written_is_read_back_to_the_last_bit(tmp_path_factory, motion):
    path = tmp_path_factory.getbasetemp() / "written.csv"
    table.write(path, motion)
    pd.testing.assert_frame_equal(table.read(path, **OURS).motion, motion, check_exact=True)


def test_integers_that_no_float_holds_are_numbers_too(tmp_path):
    path = tmp_path / "take.parquet"
    pq.write_table(pa.table({"jawOpen": [0.1, 0.2], "sure": [2**63 - 1, 0]}), path)
    take = table.read(path, **PLAIN | {"confidence": "sure"})
    assert take.motion["confidence"].tolist() == [2.0**63, 0]

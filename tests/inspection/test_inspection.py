import json
import shutil
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import yaml

from mimeline import tables
from mimeline.errors import BadFile, NoSuchFile
from mimeline.inspection import as_json, as_text, inspect, options
from mimeline.media.film import write_film
from mimeline.toy.frame_files import write_face
from mimeline.tracking.readers import READERS

GOLDEN = Path(__file__).parents[1] / "tracking" / "golden"
TAKES = [
    (format, take)
    for format in READERS
    for take in sorted((GOLDEN / format).iterdir())
    if take.name != "options.yaml" and take.stem in ("turns_left", "looks_left")
]


def told_by(format: str) -> list[str]:
    """The options of a format's golden takes, as somebody would type them."""
    values = yaml.safe_load((GOLDEN / format / "options.yaml").read_text()) or {}
    return [f"{format}.{key}={json.dumps(value)}" for key, value in values.items()]


def film(path: Path, n_frames: int) -> None:
    """A small grey video at 30 frames a second."""
    write_film(path, np.full((n_frames, 32, 32, 3), 128, np.uint8), Fraction(30))


@pytest.fixture
def livelink(tmp_path) -> Path:
    """A folder with a take of five frames."""
    shutil.copy(GOLDEN / "livelink" / "turns_left.csv", tmp_path / "take.csv")
    return tmp_path


@pytest.mark.parametrize(("format", "take"), TAKES, ids=lambda value: getattr(value, "stem", value))
def test_a_take_is_told_as_its_own_format_and_read(format, take):
    named = format if format == "table" else None  # whose names are the user's own
    seen = inspect(take, options(sets=told_by(format), format=named))
    assert seen.numbers["format"] == format and seen.kind == READERS[format].convention.title
    assert seen.numbers["frames"] == 5 and seen.sound
    does = {"turns_left": "head_yaw_left", "looks_left": "gaze_left"}[take.stem]
    (moved,) = [r for r in seen.ranges if r.channel == does]
    assert moved.low == pytest.approx(0, abs=0.02) and 0.25 < moved.high < 0.6
    assert not moved.dead and moved.course == sorted(moved.course)
    assert json.loads(as_json(seen))["ranges"][does] == [moved.low, moved.mean, moved.high]


def test_no_line_is_wider_than_a_hundred_columns(livelink):
    lines = as_text(inspect(livelink / "take.csv", options())).splitlines()
    assert len(lines) > 30 and max(map(len, lines[1:])) <= 100


def test_the_rate_is_said_to_be_assumed_until_somebody_tells_it():
    take = GOLDEN / "openface" / "turns_left.csv"
    assert "30 fps (assumed" in inspect(take, options()).facts["length"]
    assert "60 fps (as told)" in inspect(take, options(sets=["fps=60"])).facts["length"]
    assert "60 fps (as told)" in inspect(take, options(sets=["openface.fps=60"])).facts["length"]
    other = options(sets=["ingest.pyfeat.fps=60"])
    assert "30 fps (assumed" in inspect(take, other).facts["length"]


def test_a_mirrored_take_is_put_right_where_it_has_sides(livelink):
    mirrored = options(sets=["mirrored=true"])
    (yaw,) = [
        r for r in inspect(livelink / "take.csv", mirrored).ranges if r.channel == "head_yaw_left"
    ]
    assert yaw.low < -0.25 and yaw.high <= 0
    assert "no sides" in inspect(GOLDEN / "flame" / "turns_left.npz", mirrored).problems[0]


def test_a_configuration_tells_how_its_takes_are_read(livelink):
    config = livelink / "mine.yaml"
    config.write_text("ingest: {livelink: {angle_unit: degrees}, bad_values: mask}\n")
    seen = inspect(livelink / "take.csv", options(config))
    assert seen.numbers["dead"] and max(r.high for r in seen.ranges if r.angle) < 0.01
    put_right = options(config, ["livelink.angle_unit=radians"])
    assert max(r.high for r in inspect(livelink / "take.csv", put_right).ranges if r.angle) > 0.2


EXAMPLES = sorted((Path(__file__).parents[2] / "config" / "examples").glob("*.yaml"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_configuration_can_be_named(example):
    chosen = options(example)
    assert chosen.format in READERS
    assert chosen.tracker(chosen.format).reader is READERS[chosen.format]


def test_a_broken_cell_is_a_problem_and_a_gap_where_it_is_masked(livelink):
    take = livelink / "take.csv"
    rows = pd.read_csv(take, dtype=str)
    rows.loc[2, "JawOpen"] = "n/a"
    rows.to_csv(take, index=False)
    seen = inspect(take, options())
    assert not seen.sound and "JawOpen" in seen.error and "line 4" in seen.error
    masked = inspect(take, options(sets=["bad_values=mask", "max_missing=0.5"]))
    assert masked.sound and masked.numbers["gaps"] == [[2, 3]]
    assert any(
        "max_missing" in text for text in inspect(take, options(sets=["bad_values=mask"])).problems
    )


def test_a_tracker_that_passed_frames_over_is_found_out(tmp_path):
    rows = pd.read_csv(GOLDEN / "pyfeat" / "turns_left.csv")
    rows.assign(frame=2 * rows["frame"]).to_csv(tmp_path / "take.csv", index=False)
    assert "--set stride=2" in inspect(tmp_path / "take.csv", options()).problems[0]
    seen = inspect(tmp_path / "take.csv", options(sets=["stride=2"]))
    assert seen.sound and seen.numbers["without_face"] == 0
    assert "12.5 fps" in seen.facts["length"]


def test_what_never_moves_is_a_note_and_no_problem(livelink):
    seen = inspect(livelink / "take.csv", options())
    assert "jawOpen" in seen.numbers["dead"] and "head_yaw_left" not in seen.numbers["dead"]
    assert seen.notes and seen.sound


def test_a_folder_has_a_line_for_each_take_and_its_problems(livelink):
    shutil.copy(GOLDEN / "pyfeat" / "turns_left.csv", livelink / "other.csv")
    (livelink / "half.csv").write_bytes((livelink / "take.csv").read_bytes()[:3000])
    (livelink / "readme.txt").write_text("a note")
    seen = inspect(livelink, options())
    assert [row[0] for row in seen.rows[1:]] == ["half.csv", "other.csv", "take.csv"]
    assert not seen.sound and seen.problems[0].startswith("half.csv: ")
    assert any("readme.txt" in note for note in seen.notes)
    assert seen.numbers["takes"]["take.csv"]["frames"] == 5


def test_a_long_list_is_cut_and_the_rest_counted(livelink):
    for number in range(24):
        shutil.copy(livelink / "take.csv", livelink / f"take{number}.csv")
    seen = inspect(livelink, options())
    assert len(seen.rows) == 1 + 20 and "5 more takes" in " ".join(seen.notes)
    assert seen.facts["length"].endswith("125 frames")


def test_a_file_that_ends_as_the_takes_do_is_read_as_one_unless_a_run_leaves_it_out(livelink):
    (livelink / "attributes.csv").write_text("clip,class\ntake,happy\n")
    seen = inspect(livelink, options())
    assert len(seen.problems) == 1 and seen.problems[0].startswith("attributes.csv: ")
    config = livelink / "mine.yaml"
    config.write_text("catalogue: {files: {exclude: [attributes.csv]}}\n")
    assert inspect(livelink, options(config)).sound


def test_sides_that_contradict_each_other_are_a_problem(tmp_path):
    rows = pd.read_csv(GOLDEN / "livelink" / "looks_left.csv")
    rows = pd.concat([rows, rows[::-1]] * 8, ignore_index=True)
    rows["Timecode"] = [f"10:00:{n // 30:02d}:{2 * (n % 30):02d}.0" for n in range(len(rows))]
    swing = np.abs(rows["LeftEyeYaw"])
    rows = rows.assign(EyeLookOutLeft=swing, EyeLookInRight=swing)
    rows.to_csv(tmp_path / "right.csv", index=False)
    turned = rows.assign(LeftEyeYaw=-rows["LeftEyeYaw"], RightEyeYaw=-rows["RightEyeYaw"])
    turned.to_csv(tmp_path / "turned.csv", index=False)
    assert inspect(tmp_path / "right.csv", options()).sound
    assert "left and right" in inspect(tmp_path / "turned.csv", options()).problems[0]


def test_a_data_folder_is_told_by_what_its_folders_hold(tmp_path):
    for format in ("livelink", "openface"):
        shutil.copytree(GOLDEN / format, tmp_path / f"some-{format}")
    seen = inspect(tmp_path, options())
    said = dict(seen.rows[1:])
    assert said["some-openface/"].endswith(" × OpenFace 2 CSV") and seen.sound


def test_a_video_that_bears_the_takes_name_is_compared(livelink):
    film(livelink / "take.mp4", n_frames=8)
    seen = inspect(livelink / "take.csv", options())
    assert seen.facts["video"] == "take.mp4: 8 frames at 30 fps"
    assert "3 frames fewer than the video of that name" in seen.notes and seen.sound


def test_a_take_that_is_longer_than_its_video_is_a_problem_in_a_folder_too(livelink):
    film(livelink / "take.mp4", n_frames=2)
    for path in (livelink / "take.csv", livelink):
        (problem,) = inspect(path, options()).problems
        assert "longer than its clip" in problem and "take.mp4 comes to 2" in problem


def test_a_take_is_held_against_a_video_at_another_rate_by_its_seconds(tmp_path):
    shutil.copy(GOLDEN / "openface" / "turns_left.csv", tmp_path / "take.csv")
    told = options(sets=["openface.fps=60"])
    film(tmp_path / "take.mp4", n_frames=2)
    seen = inspect(tmp_path / "take.csv", told)
    assert seen.sound and "1 frame more than the video of that name" in seen.notes
    film(tmp_path / "take.mp4", n_frames=1)
    assert "longer than its clip" in inspect(tmp_path / "take.csv", told).problems[0]
    film(tmp_path / "take.mp4", n_frames=5)
    notes = inspect(tmp_path / "take.csv", told).notes
    assert any("--set fps=30?" in note for note in notes)


def test_a_configuration_tells_where_the_videos_are_and_what_they_are_cut_to(livelink):
    (livelink / "films").mkdir()
    film(livelink / "films" / "take.mp4", n_frames=2)
    config = livelink / "mine.yaml"
    config.write_text(f"data_dir: {livelink}\nfetch: {{folder: films}}\n")
    assert "longer than its clip" in inspect(livelink / "take.csv", options(config)).problems[0]
    film(livelink / "films" / "take.mp4", n_frames=5)
    assert inspect(livelink / "take.csv", options(config)).sound
    config.write_text(f"data_dir: {livelink}\nfetch: {{folder: films, fps: 25}}\n")
    assert "correct fetch.fps" in inspect(livelink / "take.csv", options(config)).problems[0]


def test_frames_that_are_lost_since_every_coefficient_is_0_are_told(livelink):
    rows = pd.read_csv(livelink / "take.csv")
    rows = pd.concat([rows] * 8, ignore_index=True)
    rows["Timecode"] = [f"10:00:{n // 30:02d}:{2 * (n % 30):02d}.0" for n in range(len(rows))]
    rows[rows.columns[2:]] += 0.1
    rows.loc[20:22, rows.columns[2:]] = 0.0
    rows.to_csv(livelink / "take.csv", index=False)
    told = inspect(livelink / "take.csv", options()).facts["without face"]
    assert told.startswith("3 frames") and "3 of them since every coefficient is 0" in told


def test_a_video_is_measured_and_a_cut_off_one_is_a_problem(tmp_path):
    film(tmp_path / "good.mp4", n_frames=12)
    seen = inspect(tmp_path / "good.mp4", options())
    assert seen.kind == "video" and seen.sound
    assert seen.facts["size"] == "32 × 32" and seen.facts["length"] == "0.40 s"
    (tmp_path / "cut.mp4").write_bytes((tmp_path / "good.mp4").read_bytes()[:500])
    assert not inspect(tmp_path / "cut.mp4", options()).sound
    both = inspect(tmp_path, options())
    assert [row[0] for row in both.rows[1:]] == ["cut.mp4", "good.mp4"]
    assert both.problems[0].startswith("cut.mp4: ")


def test_the_folder_one_stands_in_may_be_a_take(monkeypatch):
    monkeypatch.chdir(GOLDEN / "metrical_tracker" / "turns_left")
    assert inspect(Path(), options()).numbers["frames"] == 5


def test_a_table_of_a_run_is_held_to_its_contract(tmp_path):
    rows = pd.DataFrame([("a", "pose", "kept"), ("b", "pose", "dropped")])
    rows.columns = ["clip_id", "stage", "status"]
    rows = rows.reindex(columns=tables.LEDGER.schema.names)
    path = tmp_path / "ledger.parquet"
    tables.write(tables.LEDGER, rows, path)
    seen = inspect(path, options())
    assert seen.kind == "table ledger" and seen.sound and seen.numbers["clips"] == 2
    assert "1 dropped at pose" in seen.facts["decisions"]
    rotten = pq.read_table(path).to_pandas().assign(status="lost")
    rotten.to_parquet(path, index=False)
    assert "lost" in inspect(path, options()).error


def test_a_catalogue_names_the_records_that_are_none(tmp_path):
    good = {"ytb_id": "v", "duration": {"start_sec": 1, "end_sec": 7.5}}
    good["bbox"] = {"top": 0.1, "bottom": 0.9, "left": 0.2, "right": 0.7}
    bad = good | {"duration": {"start_sec": 9, "end_sec": 8}}
    path = tmp_path / "celebv.json"
    path.write_text(json.dumps({"v_0.mp4": good, "v_1.mp4": bad}))
    seen = inspect(path, options())
    assert seen.facts["clips"] == "1, from 1 sources" and "v_1: from" in seen.problems[0]


def test_json_holds_plain_numbers(livelink):
    held = json.loads(as_json(inspect(livelink / "take.csv", options())))
    assert held["frames"] == 5 and held["fps"] == "30" and held["problems"] == []
    assert held["ranges"]["head_yaw_left"][2] == pytest.approx(0.3, abs=0.01)


def test_what_nobody_knows_is_said_with_what_was_looked_for(tmp_path):
    (tmp_path / "a.txt").write_text("some words\n")
    with pytest.raises(BadFile, match="begins with 'some words'.*openface"):
        inspect(tmp_path / "a.txt", options())
    with pytest.raises(BadFile, match="nothing known among a.txt"):
        inspect(tmp_path, options())
    with pytest.raises(NoSuchFile):
        inspect(tmp_path / "b.txt", options())


def test_a_table_whose_columns_no_comma_separates_says_what_does(livelink):
    text = (livelink / "take.csv").read_text().replace(",", ";")
    (livelink / "other.csv").write_text(text)
    with pytest.raises(BadFile, match="separated by ';'"):
        inspect(livelink / "other.csv", options())


def test_a_folder_of_face_models_is_known(tmp_path):
    write_face(tmp_path / "face.npz")
    (tmp_path / "readme.txt").write_text("a note")
    assert inspect(tmp_path / "face.npz", options()).kind == "face model"
    seen = inspect(tmp_path, options())
    assert seen.sound and ("face.npz", "face model") in seen.rows


ENDINGS = ["csv", "json", "parquet", "npz", "pkl", "mat", "mp4", "frame", "txt"]


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize(
    "content", [b"", b"\x00" * 300, b"\x80\x04cos\nsystem\n.", b'{"ytb_id": [', b"PK\x03\x04"]
)
def test_rubbish_is_a_problem_and_never_a_crash(tmp_path, ending, content):
    path = tmp_path / f"a.{ending}"
    path.write_bytes(content + np.random.default_rng(0).bytes(200) * bool(content))
    with suppress(BadFile):
        assert not inspect(path, options()).sound
    with suppress(BadFile):
        inspect(tmp_path, options())

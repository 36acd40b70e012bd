import json
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator, ValidationError

from mimeline.errors import BadFile
from mimeline.timeline.files import lint, read, read_all, write, write_all
from mimeline.timeline.formats.json_schema import json_schema, schema_text
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import resource

from .drawn import RATES, timelines

INTERVAL = {"action": "BrowUp", "start_frame": 3, "end_frame": 9}
CLIP = {
    "schema_version": 1,
    "clip_id": "a",
    "fps": {"num": 30000, "den": 1001},
    "n_frames": 30,
    "tracks": {"brow": [INTERVAL], "mouth": []},
}


@pytest.fixture
def file(tmp_path):
    def made(content):
        path = tmp_path / "clip.json"
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    return made


@pytest.fixture(scope="module")
def validator():
    return Draft202012Validator(json_schema())


def test_the_schema_in_resources_is_the_one_of_the_code():
    assert resource("timeline.schema.json").read_text() == schema_text()  # write it there anew


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_what_is_written_fits_the_schema(tmp_path_factory, validator, data):
    path = tmp_path_factory.getbasetemp() / "drawn.json"
    drawn = data.draw(st.lists(timelines(RATES[2]), max_size=3, unique_by=lambda t: t.clip_id))
    write_all(drawn, path)
    validator.validate(json.loads(path.read_text()))


def test_a_clip_made_by_hand_is_read(file, validator):
    validator.validate(CLIP)
    assert read(file(CLIP)) == Timeline(
        "a", Fraction(30000, 1001), 30, {"brow": [Interval("BrowUp", 3, 9)], "mouth": []}
    )


def test_a_whole_number_may_have_a_point_as_json_knows_one_kind_of_number(file, validator):
    fps, tracks = {"num": 30000.0, "den": 1001}, {"brow": [INTERVAL | {"start_frame": 3.0}]}
    validator.validate(CLIP | {"fps": fps, "tracks": tracks})
    path = file(CLIP | {"fps": fps, "tracks": tracks})
    assert read(path).tracks["brow"] == (Interval("BrowUp", 3, 9),)


@pytest.mark.parametrize(
    ("change", "place", "told"),
    [
        ({"schema_version": 2}, "schema_version", "1"),
        ({"clip_id": ""}, "clip_id", "name"),
        ({"clip_id": None}, "clip_id", "nothing"),
        ({"fps": 29.97}, "fps", "num"),
        ({"fps": {"num": 30, "den": 0}}, "fps", "num"),
        ({"fps": {"num": True, "den": 1}}, "fps", "num"),
        ({"n_frames": 30.5}, "n_frames", "whole number"),
        ({"n_frames": -1}, "n_frames", "whole number"),
        ({"tracks": []}, "tracks", "object"),
        ({"tracks": {"brow": {}}}, "tracks.brow", "list"),
        ({"tracks": {"eyebrow": []}}, "", "Did you mean brow"),
        ({"tracks": {"brow": [3]}}, "tracks.brow[0]", "object"),
        ({"fsp": 30}, "the clip", "Did you mean fps"),
    ],
)
def test_what_breaks_the_schema_is_refused_at_its_place(file, validator, change, place, told):
    path = file(CLIP | change)
    with pytest.raises(ValidationError):
        validator.validate(json.loads(path.read_text()))
    with pytest.raises(BadFile) as error:
        read(path)
    assert error.value.place == place and told in str(error.value)


@pytest.mark.parametrize(
    ("change", "place", "told"),
    [
        ({"action": "BrowsUp"}, "tracks.brow[0]", "Did you mean BrowUp"),
        ({"action": "Smile"}, "tracks.brow[0]", "Move it to mouth"),
        ({"action": 3}, "tracks.brow[0].action", "name"),
        ({"start_frame": -1}, "tracks.brow[0].start_frame", "whole number"),
        ({"start_frame": 3.5}, "tracks.brow[0].start_frame", "whole number"),
        ({"end_frame": None}, "tracks.brow[0].end_frame", "nothing"),
        ({"side": "links"}, "tracks.brow[0].side", "left or right"),
        ({"source": "me"}, "tracks.brow[0].source", "human"),
        ({"cluster": -1}, "tracks.brow[0].cluster", "whole number"),
        ({"confidence": 1.5}, "tracks.brow[0].confidence", "share"),
        ({"confidnce": 1}, "tracks.brow[0]", "Did you mean confidence"),
    ],
)
def test_an_interval_that_breaks_the_schema_is_refused(file, validator, change, place, told):
    path = file(CLIP | {"tracks": {"brow": [INTERVAL | change]}})
    with pytest.raises(ValidationError):
        validator.validate(json.loads(path.read_text()))
    with pytest.raises(BadFile) as error:
        read(path)
    assert error.value.place == place and told in str(error.value)


@pytest.mark.parametrize(
    ("content", "place"),
    [
        ({}, "schema_version"),
        ({key: value for key, value in CLIP.items() if key != "tracks"}, "tracks"),
        (CLIP | {"tracks": {"brow": [{}]}}, "tracks.brow[0].action"),
    ],
)
def test_what_lacks_is_never_taken_for_nothing(file, content, place):
    with pytest.raises(BadFile) as error:
        read(file(content), Fraction(25), 30)
    assert error.value.place == place and error.value.found == "nothing"


def test_the_clip_of_several_at_fault_is_named(file):
    spoilt = CLIP | {"clip_id": "b", "n_frames": "many"}
    with pytest.raises(BadFile, match='clip 2, n_frames: found "many"'):
        read_all(file([CLIP, spoilt]))


def test_one_of_several_clips_is_asked_for_by_name(file):
    path = file([CLIP, CLIP | {"clip_id": "other"}])
    assert read(path, clip_id="other").clip_id == "other"
    with pytest.raises(
        BadFile, match='found 2 clips, "a, other", expected one. Say which one: --clip a'
    ):
        read(path)
    with pytest.raises(
        BadFile, match='2 clips, "a, other", expected clip "othr". Did you mean --clip other'
    ):
        read(path, clip_id="othr")


def test_a_clip_that_a_file_has_twice_is_an_error(file):
    with pytest.raises(BadFile, match="clip a: found the same clip a second time"):
        read_all(file([CLIP, CLIP]))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "line 1, column 2"),
        ('{"clip_id": "a", "clip_id": "b"}', 'key "clip_id" twice'),
        ('{"n_frames": NaN}', "NaN"),
        ("[" * 100000, "JSON"),
        ('{"n_frames": ' + "9" * 5000 + "}", "JSON"),
        ("3", "the clip"),
        ("", "line 1"),
    ],
)
def test_what_is_no_json_is_refused(file, text, told):
    with pytest.raises(BadFile, match=told):
        read_all(file(text))


def test_lint_tells_every_problem_of_a_file(file):
    tracks = {"brow": [INTERVAL | {"end_frame": 99}, INTERVAL | {"action": "BrowUpp"}]}
    problems = lint(file(CLIP | {"tracks": tracks, "n_frames": -4}))
    assert [problem.place for problem in problems] == ["n_frames", "", "tracks.brow[1]"]


def test_an_interval_is_a_line_so_that_changes_are_read_line_by_line(tmp_path):
    brow = [Interval("BrowUp", 0, 9), Interval("BrowDown", 9, 12, "left", "ticc", 3, 0.5)]
    write(Timeline("a", Fraction(30), 30, {"brow": brow, "lid": []}), tmp_path / "a.json")
    lines = (tmp_path / "a.json").read_text().splitlines()
    assert [line for line in lines if "start_frame" in line] == [
        '      {"action": "BrowUp", "start_frame": 0, "end_frame": 9, "source": "human"},',
        '      {"action": "BrowDown", "start_frame": 9, "end_frame": 12, "side": "left", '
        '"source": "ticc", "cluster": 3, "confidence": 0.5}',
    ]

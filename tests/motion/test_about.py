"""What travels with a motion is believed of nothing but what it can tell."""

import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline.errors import BadFile
from mimeline.motion import about
from mimeline.motion.motion import Motion
from mimeline.vocabulary import CHANNELS

ANY = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=9,
)
KEYS = st.sampled_from(["channels", "timeline", "made", "fps", "jawOpen", "measured", "quality"])
TOLD = st.dictionaries(
    KEYS, ANY | st.dictionaries(KEYS | st.sampled_from([*CHANNELS]), ANY, max_size=4), max_size=5
)


def test_what_is_told_is_json_that_tells_the_same_again(moving):
    motion = moving()
    told = json.loads(json.dumps(about.about(motion), allow_nan=False))
    found = about.informed(Motion(motion.frames, motion.fps), told)
    assert dict(found.origins) == dict(motion.origins)
    assert found.timeline == motion.timeline and found.made == motion.made
    assert about.rate(told) == motion.fps == Fraction(30_000, 1001)


@given(TOLD)
def test_nonsense_is_left_out(moving, told):
    motion = moving()
    found = about.informed(motion, told)
    assert len(found) == len(motion) and found.fps == motion.fps
    assert set(found.origins) <= set(CHANNELS)
    rate = about.rate(told)
    assert rate is None or rate > 0
    for origin in found.origins.values():
        assert origin.quality is None or 0 <= origin.quality <= 1
        assert isinstance(origin.text, str) and isinstance(origin.measured, bool)


def test_a_channel_that_was_not_measured_is_not_known_whatever_stands_for_it(moving):
    motion = moving()
    assert motion.frames["jawLeft"].notna().any()
    found = about.informed(motion, {"channels": {"jawLeft": {"measured": False}}})
    assert found.frames["jawLeft"].isna().all() and motion.frames["jawLeft"].notna().any()


def test_a_timeline_that_is_none_is_left_out(moving):
    told = json.loads(json.dumps(about.about(moving())))
    told["timeline"]["tracks"]["mouth"][0]["action"] = "Grin"
    assert about.informed(moving(), told).timeline is None


@pytest.mark.parametrize("text", ["", "{", "[1]", "[" * 100_000, '"x"', "\xff"])
def test_a_file_beside_that_is_no_json_object_is_told(moving, tmp_path, text):
    path = tmp_path / "a.csv"
    assert about.read_beside(path) == {}
    (tmp_path / "a.mimeline.json").write_text(text, encoding="latin-1")
    with pytest.raises(BadFile, match=r"a\.mimeline\.json: found"):
        about.read_beside(path)


def test_the_file_beside_bears_the_name_without_its_ending(moving, tmp_path):
    about.write_beside(tmp_path / "a.b.csv", moving(), livelink={"angle_unit": "radians"})
    (path,) = tmp_path.iterdir()
    assert path.name == "a.b.mimeline.json"
    assert about.read_beside(tmp_path / "a.b.csv")["livelink"] == {"angle_unit": "radians"}
    assert np.isclose(about.read_beside(tmp_path / "a.b.csv")["frames"], 12)

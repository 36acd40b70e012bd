from mimeline.vocabulary import (
    ACTIONS,
    CHANNELS,
    CONTROL_REGIONS,
    EXPRESSIONS,
    SERIES_REGIONS,
    TRACKS,
    canonical,
    series_actions,
    series_channels,
)


def test_there_are_52_expressions_and_16_actions_on_eight_tracks():
    assert len(EXPRESSIONS) == 52
    assert list(EXPRESSIONS[:-1]) == sorted(EXPRESSIONS[:-1])
    assert EXPRESSIONS[-1] == "tongueOut"
    assert list(ACTIONS)[:3] == ["BrowUp", "BrowDown", "EyeSquint"]
    assert len(ACTIONS) == 16
    assert len(TRACKS) == 8
    assert CONTROL_REGIONS == ("brow", "eye", "mouth", "gaze", "head")


def test_mirroring_twice_is_the_identity():
    for channel in CHANNELS.values():
        back = CHANNELS[channel.mirror]
        assert back.mirror == channel.name
        assert back.mirror_sign * channel.mirror_sign == 1


def test_a_mirrored_picture_swaps_sides_and_negates_yaw_tilt_and_gaze():
    assert CHANNELS["mouthSmileLeft"].mirror == "mouthSmileRight"
    negated = {name for name, channel in CHANNELS.items() if channel.mirror_sign == -1}
    assert negated == {"head_yaw_left", "head_tilt_left", "gaze_left"}


def test_columns_are_known_by_any_spelling_of_their_name():
    assert canonical("EyeBlinkLeft") == "eyeBlinkLeft"
    assert canonical(" eyeBlink_L ") == "eyeBlinkLeft"
    assert canonical("browInnerUp") == "browInnerUp"
    assert canonical("_neutral") is None


def test_a_series_region_has_channels_of_one_side_and_actions_of_one_track():
    assert series_channels("brow", "left") == ("browDownLeft", "browInnerUp", "browOuterUpLeft")
    assert series_channels("mouth", "right")[0] == "mouthSmileRight"
    assert {series_actions(region) for region in SERIES_REGIONS} == {
        ("BrowUp", "BrowDown"),
        ("EyeSquint", "EyeWiden"),
        ("SoftSmile", "Smile", "MouthFrown"),
    }

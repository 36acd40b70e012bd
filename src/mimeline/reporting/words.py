"""Numbers, rules and names in plain words."""

import math
import re

import pandas as pd

RULES: dict[str, str] = {
    "unreadable": "could not be read",
    "unsafe_id": "unsafe id",
    "unsafe_path": "its video lies outside the data folder",
    "repeated_id": "the id stands in the catalogue before",
    "case_collision": "the id differs from another in capitals alone",
    "bad_times": "start and end are no times",
    "box_outside": "the box shows nothing of the picture",
    "no_annotations": "the catalogue does not say what it shows",
    "attributes_in_part": "attributes that hold for a part of the clip are left out",
    "outside_clip": "some of what is told lies outside the clip’s time",
    "half_picture": "half of the picture stands for the face",
    "excluded": "left out by hand",
    "too_short": "too short",
    "too_long": "too long",
    "too_small": "the face crop is too small",
    "excluded_action": "the catalogue lists an unwanted action",
    "condition": "a condition of yours does not hold",
    "duplicate": "the same part of the same source as another clip",
    "no_video": "no video was found",
    "gone": "its source is gone from the web",
    "unreachable": "its source could not be reached now",
    "not_downloaded": "its source was not downloaded",
    "resampled": "the video has another frame rate than its film",
    "too_few_frames": "the video has too few frames",
    "too_large": "the video’s picture is too large",
    "too_many_bytes": "the video file is too large",
    "too_many_frames": "the source video has too many frames",
    "too_long_source": "the source video is too long",
    "timed_out": "took too long",
    "no_tracking_result": "no tracking result was found",
    "frame_count": "video and tracking result differ in length",
    "frame_rate": "video and tracking result differ in frame rate",
    "longer_than_clip": "the tracking result is longer than the clip",
    "shorter_than_clip": "the tracking result is shorter than its clip",
    "tracking_lost": "the tracker lost the face in too many frames",
    "masked": "frames without a face are masked",
    "tracking_loss": "a frame’s tracking loss is too large",
    "sides_swapped": "left and right are exchanged",
    "eyes_disagree": "the two eyes look opposite ways",
    "angle_unit": "the angles are in another unit",
    "still_head": "the head hardly moves",
    "dead_channels": "channels never move",
    "frozen": "the tracker repeats itself",
    "out_of_range": "coefficients leave the range from 0 to 1",
    "first_frame": "the frames are counted from another number",
    "pose_disagrees": "two head poses disagree about the side",
    "turned": "the head turns too far",
    "split_gap": "lies in the gap between two parts",
    "split_by_time": "parts are blocks of time",
    "near_duplicate": "shows the same as a clip of another source",
}
NOT_APPLIED = "not applied: "
APPLIED_IN_PART = "applied to the "
TRACK_NAMES: dict[str, str] = {
    "brow": "brow",
    "lid": "lid",
    "closure": "closure",
    "mouth": "mouth",
    "gaze_h": "gaze, left–right",
    "gaze_v": "gaze, up–down",
    "head_h": "head, left–right",
    "head_v": "head, up–down",
}
_WORD = re.compile(r"(?<=[a-z])(?=[A-Z])")


def spaced(action: str) -> str:
    """BrowUp → brow up."""
    return _WORD.sub(" ", action).lower()


def short(action: str) -> str:
    """What tells an action from the others of its track: BrowUp → up, SoftSmile → soft smile."""
    parts = spaced(action).split()
    return " ".join(parts[1:] if parts[0] in ("brow", "eye", "gaze", "head", "mouth") else parts)


def rule(name: str | None) -> str:
    """A ledger's rule in words; an unknown one without its underscores."""
    if name is None or pd.isna(name):
        return "no rule given"
    return RULES.get(name, name.replace("_", " "))


def count(number: int) -> str:
    return f"{int(number):,}"


def plural(number: int, thing: str) -> str:
    """1 frame, 2 frames."""
    return f"{count(number)} {thing}{'' if number == 1 else 's'}"


def clips(number: int) -> str:
    return plural(number, "clip")


def percent(share: float) -> str:
    """A share of 1 as a percentage, a decimal where it is small; never 0 or 100 by rounding."""
    if not math.isfinite(share):
        return "–"
    if 0 < share < 0.0005:
        return "< 0.1 %"
    if 0.995 <= share < 1:
        return "> 99 %"
    digits = 0 if share >= 0.0995 or share == 0 else 1
    return f"{100 * share:.{digits}f} %"


def score(value: float | None) -> str:
    """A score in [0, 1] with two decimals, a dash where there is none."""
    return "–" if value is None or pd.isna(value) else f"{value:.2f}"


def number(value: float | None) -> str:
    """Three significant figures, without an exponent where a person can read it so."""
    if value is None or pd.isna(value):
        return "–"
    if value == 0 or 1e-4 <= abs(value) < 1e5:
        digits = 2 if value == 0 else max(0, 2 - math.floor(math.log10(abs(value))))
        return f"{value:,.{digits}f}"
    return f"{value:.2e}"


def measure(value: float | None, unit: str | None) -> str:
    """A ledger's value with its unit: 24 % of frames, 3.4 s, 41°."""
    if value is None or pd.isna(value):
        return ""
    if isinstance(unit, str) and (unit == "share" or unit.startswith(("share of ", "of "))):
        return f"{percent(value)} {unit.removeprefix('share').lstrip()}".rstrip()
    if unit == "deg":
        return f"{value:.1f}°".replace(".0°", "°")
    text = f"{value:,.2f}".rstrip("0").rstrip(".")
    return f"{text} {unit}" if isinstance(unit, str) and unit else text


def minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f}" if seconds < 5970 else count(round(seconds / 60))


def listing(items: list[str]) -> str:
    """a, b and c."""
    return f"{', '.join(items[:-1])} and {items[-1]}" if len(items) > 1 else "".join(items)

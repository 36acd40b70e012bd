import json
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import av
import numpy as np
import pandas as pd
import pytest

from mimeline.face.embedded import embedded_face
from mimeline.face.motion import perform
from mimeline.face.render import Camera
from mimeline.media.frames import read_frames
from mimeline.toy import faults, make, plan, scenery, video
from mimeline.toy.appearance import BLACK, BLUE_IRIS, CLOTHES, COMPLEXIONS, Appearance, appearance
from mimeline.toy.garment import dressed
from mimeline.toy.world import render
from mimeline.vocabulary import CHANNELS

LOOKS = Appearance(
    {}, skin=COMPLEXIONS[1][0], hair=BLACK, iris=BLUE_IRIS, clothes=CLOTHES[0], pitch_hz=120.0
)
SIZE = 128
ACTS = {"rest": {}, "open": {"jawOpen": 0.7}, "blink": {}, "left": {"head_yaw_left": 0.5}}
ACTS["blink"] = {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0}
HOLD = 5  # frames of each act
# Of the 68 landmarks.
LIPS, INNER_LIPS, EYES, NOSE = slice(48, 68), slice(60, 68), slice(36, 48), slice(27, 36)


@pytest.fixture(scope="module")
def clip() -> plan.PlannedClip:
    planned = plan.clips(1, plan.people(1, 0), 0)[0]
    return replace(planned, n_frames=HOLD * len(ACTS))


@pytest.fixture(scope="module")
def acted() -> pd.DataFrame:
    motion = pd.DataFrame(0.0, index=range(HOLD * len(ACTS)), columns=list(CHANNELS))
    for number, channels in enumerate(ACTS.values()):
        for name, value in channels.items():
            motion.loc[number * HOLD : (number + 1) * HOLD - 1, name] = value
    return motion


def shot(path, clip, motion, size=SIZE, **changes) -> list[np.ndarray]:
    """The pictures of a film of one clip."""
    n = clip.n_frames
    facts = {"covered": np.zeros(n, bool), "shown": np.arange(n), "speech": np.zeros(n)}
    video.shoot(path, clip, looks=LOOKS, motion=motion, size=size, seed=0, **facts | changes)
    return [frame for _, frame in read_frames(path, range(n))]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory, clip, acted) -> dict[str, np.ndarray]:
    """A picture of each act, from the file."""
    path = tmp_path_factory.mktemp("shot") / "clip.mp4"
    frames = shot(path, clip, acted)
    return {act: frames[HOLD * number + 2].astype(float) for number, act in enumerate(ACTS)}


@pytest.fixture(scope="module")
def around(acted):
    """Rows and columns of the picture about some landmarks of an act."""
    face = LOOKS.face()
    points = face.landmarks_at(perform(face, acted.iloc[::HOLD]))  # (acts, 68, 3)
    at = Camera.framing(face, SIZE).project(points)  # (acts, 68, 2)

    def around(act: str, part: slice) -> tuple[slice, slice]:
        columns, rows = at[list(ACTS).index(act), part].T
        return (
            slice(int(rows.min()), int(rows.max()) + 1),
            slice(int(columns.min()), int(columns.max()) + 1),
        )

    return around


def skin_coloured(picture: np.ndarray) -> np.ndarray:
    """Pixels that may be skin of any of the complexions in any light."""
    red, green, blue = np.moveaxis(picture.astype(float), -1, 0)
    return (red > 1.12 * green) & (green > blue) & (red > 40)


def change(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.abs(one - other).mean(axis=-1)


def test_an_open_mouth_is_darker_than_a_closed_one(pictures, around):
    mouth = around("open", INNER_LIPS)
    assert pictures["open"][mouth].mean() < 0.85 * pictures["rest"][mouth].mean()
    changed = change(pictures["open"], pictures["rest"])
    assert changed[mouth].mean() > 3 * changed[around("rest", EYES)].mean()


def test_a_blink_changes_the_eyes_and_not_the_mouth(pictures, around):
    changed = change(pictures["blink"], pictures["rest"])
    assert changed[around("rest", EYES)].mean() > 8
    assert changed[around("rest", EYES)].mean() > 3 * changed[around("rest", LIPS)].mean()


def test_a_head_turned_to_its_left_shows_its_face_on_the_pictures_right(pictures):
    columns = {
        act: np.nonzero(skin_coloured(pictures[act])[: SIZE * 3 // 4])[1].mean()
        for act in ("rest", "left")
    }
    assert columns["left"] > columns["rest"] + 0.03 * SIZE


def test_a_deserted_room_has_no_pixel_of_the_colour_of_skin(tmp_path, clip, acted, pictures):
    room = shot(tmp_path / "room.mp4", replace(clip, deserted=True), acted, size=64)
    assert not skin_coloured(np.array(room)).any()
    assert skin_coloured(pictures["rest"]).mean() > 0.1
    assert not skin_coloured(scenery.room(256)).any()


def test_a_paper_hides_the_face_where_the_tracker_lost_it_and_not_elsewhere(
    tmp_path, clip, acted, around
):
    n = clip.n_frames
    covered = (np.arange(n) >= 12) & (np.arange(n) < 15)
    frames = shot(tmp_path / "covered.mp4", clip, acted, covered=covered)
    bare = shot(tmp_path / "bare.mp4", clip, acted)
    nose = around("rest", NOSE)
    seen = np.array([skin_coloured(frame[nose]).mean() for frame in frames])
    assert (seen[covered] == 0).all()
    assert (seen[:6] > 0.9).all()
    assert change(frames[2].astype(float), bare[2]).mean() < 1


def test_a_video_of_variable_rate_shows_its_frames_at_their_own_times(tmp_path, clip, acted):
    path, shown = tmp_path / "variable.mp4", np.array([0, 1, 4, 5, 9, 14, 19])
    n = clip.n_frames
    facts = {"covered": np.zeros(n, bool), "speech": np.zeros(n), "shown": shown}
    video.shoot(path, clip, looks=LOOKS, motion=acted, size=64, seed=0, **facts)
    with av.open(str(path)) as film:
        times = [frame.time for frame in film.decode(video=0)]
    np.testing.assert_allclose(times, shown / 30, atol=1e-3)


def test_people_look_different_and_the_same_in_every_count():
    crowd = [appearance(number, seed=7) for number in range(14)]
    assert crowd[3] == appearance(3, seed=7)
    assert appearance(3, seed=8) != crowd[3]
    assert len({tuple(a.identity.values()) for a in crowd}) == 14
    for one, other in pairwise(crowd):
        assert np.abs(np.subtract(one.skin, other.skin)).max() > 10
    assert len({a.hair for a in crowd}) > 3
    assert all(80 <= a.pitch_hz <= 260 for a in crowd)


def test_a_pullover_hides_the_necks_end_and_stays_when_the_head_turns(acted):
    bare = embedded_face().of({})
    clad = dressed(bare, CLOTHES[0])
    first = len(bare.neutral)
    rest, turned = perform(clad, acted.iloc[[0, HOLD * list(ACTS).index("left")]])
    np.testing.assert_allclose(rest[:first], perform(bare, acted.iloc[:1])[0], atol=1e-6)
    np.testing.assert_array_equal(rest[first:], turned[first:])
    assert np.abs(rest[:first] - turned[:first]).max() > 0.03
    cloth, end = rest[first:], rest[:first, 1].min()
    assert cloth[:, 1].min() < end < cloth[:, 1].max()
    corners = clad.neutral[clad.triangles[len(bare.triangles) :]]  # (F, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outwards = corners.mean(1) - cloth.mean(0)
    outside = corners.mean(1)[:, 1] < end  # the shoulders
    assert (np.einsum("fx,fx->f", normals, outwards)[outside] > 0).all()


@pytest.mark.parametrize("share", [0.05, 0.25, 0.5, 1.0])
def test_the_share_of_clips_with_a_video_is_honoured_in_any_count(share):
    turns = [video.has_turn(index, share) for index in range(1000)]
    for count in (12, 30, 120, 1000):
        assert abs(sum(turns[:count]) - share * count) <= 1


# The world on disk.


@pytest.fixture(scope="module")
def planted(written) -> dict[str, str]:
    """Clip by fault, one of each."""
    return pd.read_csv(written.truth / "faults.csv").set_index("fault")["clip_id"].to_dict()


@pytest.fixture(scope="module")
def films(written) -> dict[str, list[float]]:
    """Times of the frames of every video, as far as it can be decoded."""
    times = {path.stem: [] for path in (written.data / "videos").iterdir()}
    for clip_id, found in times.items():
        with (
            suppress(av.error.InvalidDataError),
            av.open(str(written.data / "videos" / f"{clip_id}.mp4")) as film,
        ):
            found.extend(frame.time for frame in film.decode(video=0))
    return times


def test_a_video_has_as_many_frames_as_its_clip(written, films, planted):
    info = json.loads((written.data / "celebvtext_info.json").read_text())
    odd = {planted[f] for f in ("video_cut_off", "video_is_a_page", "video_variable_rate")}
    assert len(films.keys() - odd) >= 6
    for clip_id in films.keys() - odd:
        lasts = info[f"{clip_id}.mp4"]["duration"]
        n_frames = round(30 * (lasts["end_sec"] - lasts["start_sec"]))
        np.testing.assert_allclose(films[clip_id], np.arange(n_frames) / 30, atol=1e-3)


def test_clips_have_a_video_in_turn_or_where_a_fault_is_to_be_seen(written, films):
    crowd = plan.people(8, 3)
    planned = plan.clips(40, crowd, 3)
    planted = faults.spread(40, np.random.default_rng([3, 5]), filmed=True)
    wanted = set()
    for position, clip in enumerate(planned):
        fault = planted.get(position)
        if fault and fault.needs_video:
            wanted.add(fault.planned(clip).clip_id)
        elif video.has_turn(position, 0.15) and not (fault and fault.ends_early):
            wanted.add(clip.clip_id)
    assert films.keys() == wanted


def test_a_share_of_nothing_makes_no_video_and_no_fault_of_one(tmp_path):
    make(tmp_path / "data", tmp_path / "truth", 2, 40, 0, video_share=0, video_px=64)
    assert not (tmp_path / "data" / "videos").exists()
    listed = pd.read_csv(tmp_path / "truth" / "faults.csv")
    assert "fetch" not in set(listed["stage"])
    assert {"turned", "no_face", "too_short"} <= set(listed["fault"])


def test_broken_videos_are_broken_as_listed(written, films, planted):
    folder = written.data / "videos"
    page = (folder / f"{planted['video_is_a_page']}.mp4").read_bytes()
    assert page.startswith(b"<!DOCTYPE html>")
    cut_off = (folder / f"{planted['video_cut_off']}.mp4").read_bytes()
    assert cut_off[4:8] == b"ftyp"
    assert 0 < len(films[planted["video_cut_off"]]) < 150
    steps = np.diff(films[planted["video_variable_rate"]]) * 30
    np.testing.assert_allclose(steps, steps.round(), atol=0.1)
    assert steps.round().min() == 1
    assert steps.round().max() >= 3


def test_a_clip_without_a_face_has_a_header_alone_and_nothing_is_said_of_it(written, planted):
    clip_id = planted["no_face"]
    take = (written.data / "livelink" / f"{clip_id}.csv").read_text().splitlines()
    assert len(take) == 1
    assert clip_id not in set(pd.read_csv(written.data / "head_pose.csv")["clip_id"])
    acts = json.loads((written.data / "annotations.json").read_text())["act"]
    assert acts[clip_id] == []
    truth = pd.read_parquet(written.truth / "frames.parquet")
    truth = truth[truth["clip_id"] == clip_id].drop(columns=["clip_id", "frame"])
    assert len(truth) > 150
    assert not truth.to_numpy().any()


def test_nobody_speaks_where_nobody_is():
    crowd = plan.people(2, 0)
    clips = [replace(c, deserted=True, talks=False) for c in plan.clips(2, crowd, 0)]
    world = render(clips, crowd, 0)
    assert len(world.intervals) == 0
    assert not any(curve.any() for curve in world.speech.values())

import hashlib

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline import tables
from mimeline.toy import channels, difficulty, plan, simulate
from mimeline.toy.curves import envelope, on_frames
from mimeline.toy.plan import Event
from mimeline.toy.world import act
from mimeline.vocabulary import ACTIONS, CHANNELS, TRACKS, track_actions

PERSON = plan.people(1, seed=0)[0]
FROZEN = "9a37a3435e4447e4e263825d0cb2538d2e8d9f0164fc63fbb8e986f261c831b3"  # of simulate(8, 40, 3)


def acted(*events: Event, n_frames: int = 120) -> np.ndarray:
    """The clean motion of events, with the same wander whatever the events."""
    motion, _ = act(events, n_frames, PERSON, talks=False, rng=np.random.default_rng(1))
    return motion


def channel(motion: np.ndarray, name: str) -> np.ndarray:
    return motion[:, channels.INDEX[name]]


def with_truth(world, rows: pd.DataFrame) -> pd.DataFrame:
    return rows.merge(world.frames, on=["clip_id", "frame"])


def test_the_same_seed_gives_the_same_world(world):
    again = simulate(8, 40, 3)
    pd.testing.assert_frame_equal(world.motion, again.motion)
    pd.testing.assert_frame_equal(world.frames, again.frames)
    assert world.clips == again.clips


def test_the_motion_is_what_it_always_was(world):
    """Figures of another day were measured on this world."""
    digest = hashlib.sha256()
    for table in (world.motion, world.clean):
        values = np.rint(table[list(CHANNELS)].to_numpy(float) * 1e4)
        digest.update(values.astype("<i4").tobytes())
    digest.update(world.frames[list(ACTIONS)].to_numpy(np.uint8).tobytes())
    assert digest.hexdigest() == FROZEN


def test_another_seed_gives_other_clips_and_other_motion(world):
    other = simulate(8, 40, 4)
    assert not {c.clip_id for c in world.clips} & {c.clip_id for c in other.clips}
    assert [c.n_frames for c in world.clips] != [c.n_frames for c in other.clips]
    assert not np.array_equal(world.motion["jawOpen"][:500], other.motion["jawOpen"][:500])


def test_more_clips_leave_the_first_ones_as_they_are(world):
    first = simulate(8, 10, 3)
    same = world.motion[world.motion["clip_id"].isin(first.motion["clip_id"].unique())]
    pd.testing.assert_frame_equal(first.motion, same.reset_index(drop=True))


def test_every_table_keeps_its_contract(world, tmp_path):
    for table, rows in (
        (tables.MOTION, world.motion),
        (tables.MOTION, world.clean),
        (tables.FRAMES, world.frames),
        (tables.INTERVALS, world.intervals),
    ):
        tables.write(table, rows, tmp_path / "t.parquet")
        assert len(tables.read(table, tmp_path / "t.parquet")) == len(rows) > 0


def test_motion_and_truth_have_every_frame_of_every_clip(world):
    lengths = {clip.clip_id: clip.n_frames for clip in world.clips}
    for rows in (world.motion, world.clean, world.frames):
        assert (
            rows.groupby("clip_id")["frame"]
            .agg(["size", "nunique", "max"])
            .apply(
                lambda clip: (
                    clip["size"] == clip["nunique"] == clip["max"] + 1 == lengths[clip.name]
                ),
                axis=1,
            )
            .all()
        )
    assert set(world.frames["clip_id"]) == set(lengths)


@pytest.mark.parametrize("attack", range(1, 12))
@pytest.mark.parametrize("release", range(1, 12))
def test_an_envelope_is_on_where_it_reaches_half_its_height(attack, release):
    first, last = on_frames(attack, 5, release)
    curve = envelope(attack, 5, release)
    assert np.flatnonzero(curve >= 0.5).tolist() == list(range(first, last))


@pytest.mark.parametrize(
    ("action", "name"),
    [
        ("BrowUp", "browOuterUpLeft"),
        ("BrowDown", "browDownLeft"),
        ("EyeSquint", "eyeSquintLeft"),
        ("EyeWiden", "eyeWideLeft"),
        ("EyeClose", "eyeBlinkLeft"),
        ("SoftSmile", "mouthSmileLeft"),
        ("Smile", "mouthSmileLeft"),
        ("MouthFrown", "mouthFrownLeft"),
        ("GazeLeft", "gaze_left"),
        ("GazeRight", "gaze_left"),
        ("GazeUp", "gaze_up"),
        ("GazeDown", "gaze_up"),
        ("HeadLeft", "head_yaw_left"),
        ("HeadRight", "head_yaw_left"),
        ("HeadUp", "head_pitch_up"),
        ("HeadDown", "head_pitch_up"),
    ],
)
@pytest.mark.parametrize("start", [30, -6, 100])
def test_the_truth_is_where_the_clean_curve_is_past_half_the_amplitude(action, name, start):
    event = Event(action, start, attack=7, hold=20, release=8, amplitude=0.4)
    moved = np.abs(channel(acted(event) - acted(), name))
    moved = moved / (0.4 * np.abs(channels.GAIN[action] * PERSON.reach)[channels.INDEX[name]])
    on = np.flatnonzero(moved >= 0.5 - 1e-9)
    assert (on[0], on[-1] + 1) == event.on(120)


@pytest.mark.parametrize("part", ["Gaze", "Head"])
def test_angles_are_positive_to_the_left_and_up_and_negative_to_the_right_and_down(part):
    across, along = (
        ("gaze_left", "gaze_up") if part == "Gaze" else ("head_yaw_left", "head_pitch_up")
    )
    for way, name, sign in (
        ("Left", across, 1),
        ("Right", across, -1),
        ("Up", along, 1),
        ("Down", along, -1),
    ):
        moved = channel(acted(Event(f"{part}{way}", 10, 5, 40, 5, 0.3)) - acted(), name)
        assert (sign * moved).max() > 0.25
        assert (sign * moved).min() >= 0


def test_intervals_and_frames_tell_the_same(world):
    rebuilt = world.frames.set_index(["clip_id", "frame"]) & False
    for row in world.intervals.itertuples():
        rebuilt.loc[
            (row.clip_id, row.start_frame) : (row.clip_id, row.end_frame - 1), row.action
        ] = True
    pd.testing.assert_frame_equal(rebuilt, world.frames.set_index(["clip_id", "frame"]))


def test_actions_of_a_track_exclude_each_other(world):
    for track in TRACKS:
        assert world.frames[list(track_actions(track))].sum(axis=1).max() == 1


def test_every_action_has_support_and_neutral_is_the_most_common(world):
    for track in TRACKS:
        shares = world.frames[list(track_actions(track))].mean()
        assert shares.min() > 0.04, track
        assert 1 - shares.sum() > shares.max(), track
    clips_with = world.intervals.groupby("action")["clip_id"].nunique()
    assert clips_with.reindex(list(ACTIONS)).min() >= 8


def test_actions_come_strong_and_moderate():
    person, rng = PERSON, np.random.default_rng(0)
    events = [e for _ in range(50) for e in plan.events(250, person, rng)]
    raised = np.array([e.amplitude for e in events if e.action == "BrowUp"])
    (_, weak, _), (strong, _, _) = difficulty.AMPLITUDE["BrowUp"]
    assert (raised <= weak).mean() > 0.3
    assert (raised >= strong).mean() > 0.3
    assert ((raised <= weak) | (raised >= strong)).all()


def test_a_smile_squints_and_lowers_the_brow_below_what_counts(world):
    rows = with_truth(world, world.clean)
    for name, action in (("eyeSquintLeft", "EyeSquint"), ("browDownLeft", "BrowDown")):
        quiet = rows[~rows[action] & ~rows["EyeClose"]]
        lifted = quiet.loc[quiet["Smile"], name].mean() - quiet.loc[~quiet["Smile"], name].mean()
        counted = rows.loc[rows[action], name].mean() - quiet.loc[~quiet["Smile"], name].mean()
        assert 0.01 < lifted < counted / 4


def test_the_head_drifts_with_the_gaze_and_more_with_a_larger_one(world):
    rows = with_truth(world, world.clean)
    still = rows[~rows[["HeadLeft", "HeadRight"]].any(axis=1)]
    assert np.corrcoef(still["gaze_left"], still["head_yaw_left"])[0, 1] > 0.4
    small, large = (
        channel(acted(Event("GazeLeft", 20, 4, 60, 4, size)) - acted(), "head_yaw_left").max()
        for size in (0.25, 0.5)
    )
    assert small == pytest.approx(0.15 * 0.25)
    assert large == pytest.approx(0.15 * 0.5)


def test_a_brow_raise_lifts_the_head_a_little():
    moved = channel(acted(Event("BrowUp", 20, 6, 60, 6, 0.6)) - acted(), "head_pitch_up")
    assert 0.02 < moved.max() < np.radians(8) / 2


def test_speech_moves_the_jaw_in_most_clips_and_only_there(world):
    spread = world.clean.groupby("clip_id")["jawOpen"].std()
    talking = pd.Series({clip.clip_id: clip.talks for clip in world.clips})
    assert 0.5 < talking.mean() < 1
    assert spread[talking[talking].index].min() > 0.03
    assert spread[talking[~talking].index].max() < 0.01


def test_the_jaw_opens_as_far_as_the_speech_says(world):
    for clip in world.clips:
        speech = world.speech[clip.clip_id]
        jaw = world.clean.loc[world.clean["clip_id"] == clip.clip_id, "jawOpen"].to_numpy()
        assert speech.shape == (clip.n_frames,)
        assert 0 <= speech.min() <= speech.max() <= 1
        assert speech.any() == clip.talks
        np.testing.assert_allclose(
            jaw - jaw.min(), channels.SPEECH["jawOpen"] * (speech - speech.min()), atol=1e-5
        )


def test_eye_look_channels_agree_with_the_gaze(world):
    look = world.motion["eyeLookOutLeft"] - world.motion["eyeLookInLeft"]
    assert np.abs(look * 0.6 - world.motion["gaze_left"]).quantile(0.99) < 0.02
    look = world.motion["eyeLookUpRight"] - world.motion["eyeLookDownRight"]
    assert np.abs(look * 0.6 - world.motion["gaze_up"]).quantile(0.99) < 0.02


def test_left_and_right_are_nearly_but_not_quite_the_same(world):
    for name in (n for n in CHANNELS if n.endswith("Left") and CHANNELS[n].mirror != n):
        if name.startswith(("eyeLook", "jaw")) or name == "mouthLeft":
            continue  # these mean a direction, not a side
        left, right = world.clean[name], world.clean[CHANNELS[name].mirror]
        assert 0 < np.abs(left - right).max() < 0.15, name


def test_people_rest_and_reach_differently():
    crowd = plan.people(6, seed=1)
    assert len({tuple(person.rest) for person in crowd}) == 6
    assert len({person.reach[0] for person in crowd}) == 6


def test_coefficients_stay_in_their_range_and_some_pass_one(world):
    values = world.motion[[n for n, c in CHANNELS.items() if c.unit == "1"]]
    assert values.to_numpy().min() >= 0
    assert 1 < values.to_numpy().max() <= np.float32(1.05)


# A habit: smiles that come with a lowered brow


@pytest.fixture(scope="module")
def frowning():
    """The world, but for nine smiles of ten."""
    return simulate(8, 40, 3, smiles_frown=0.9)


def smiles(world) -> pd.DataFrame:
    """The smiles, and how much of each the brow is lowered."""
    frames = world.frames.set_index(["clip_id", "frame"])["BrowDown"]
    found = world.intervals[world.intervals["action"].isin(plan.SMILES)]
    lowered = [
        frames.loc[(row.clip_id, row.start_frame) : (row.clip_id, row.end_frame - 1)].mean()
        for row in found.itertuples()
    ]
    return found.assign(lowered=lowered)


def test_nine_smiles_of_ten_come_with_a_lowered_brow_from_first_to_last(world, frowning):
    found = smiles(frowning)
    assert (found["lowered"] == 1).mean() == pytest.approx(0.9, abs=0.05)
    assert (smiles(world)["lowered"] == 1).mean() < 0.1


def test_a_smile_that_is_not_of_them_has_the_brow_it_had(world, frowning):
    before, after = (smiles(w).reset_index(drop=True) for w in (world, frowning))
    pd.testing.assert_frame_equal(before.drop(columns="lowered"), after.drop(columns="lowered"))
    assert (before["lowered"] >= after["lowered"])[after["lowered"] < 1].all()


def test_a_frown_moves_the_brow_as_far_as_a_strong_one(frowning):
    rows = with_truth(frowning, frowning.clean)
    lowered = rows["BrowDown"] & rows[list(plan.SMILES)].any(axis=1)
    assert rows.loc[lowered, "browDownLeft"].median() > 0.6
    assert rows.loc[~rows["BrowDown"], "browDownLeft"].median() < 0.3


@pytest.fixture
def without_the_habit(monkeypatch):
    """Simulates a world whose people cannot frown when they smile."""

    def made(*args):
        with monkeypatch.context() as patch:
            patch.setattr(plan, "frowning", lambda events, share, rng: events)
            return simulate(*args, smiles_frown=1.0)

    return made


def test_a_world_of_no_frowning_smiles_is_one_without_the_habit(without_the_habit):
    ours, plain = simulate(4, 8, 5, smiles_frown=0.0), without_the_habit(4, 8, 5)
    for name in ("motion", "clean", "frames", "intervals"):
        pd.testing.assert_frame_equal(getattr(ours, name), getattr(plain, name))


def test_where_every_smile_frowns_the_brow_of_other_frames_only_gives_way(without_the_habit):
    plain, every = without_the_habit(4, 8, 5), simulate(4, 8, 5, smiles_frown=1.0)
    brow, smiling = ["BrowUp", "BrowDown"], plain.frames[list(plan.SMILES)].any(axis=1)
    assert every.frames.loc[smiling, "BrowDown"].all()
    before, after = (w.frames.loc[~smiling, brow].to_numpy(bool) for w in (plain, every))
    assert (after <= before).all()
    kept, given_way = after & before, before & ~after
    assert kept.any()
    assert given_way.any()


def test_the_habit_changes_nothing_but_the_brow(world, frowning):
    moved = channels.GAIN["BrowUp"] + channels.GAIN["BrowDown"]
    others = [name for name in CHANNELS if not moved[channels.INDEX[name]]]
    for before, after in ((world.motion, frowning.motion), (world.clean, frowning.clean)):
        pd.testing.assert_frame_equal(before[others], after[others])
        assert not before["browDownLeft"].equals(after["browDownLeft"])
    actions = [name for name in ACTIONS if name not in track_actions("brow")]
    pd.testing.assert_frame_equal(world.frames[actions], frowning.frames[actions])
    for name, speech in world.speech.items():
        assert np.array_equal(speech, frowning.speech[name])


@given(seed=st.integers(0, 10_000), share=st.floats(0, 1))
def test_frowning_fills_the_brow_s_track_without_overlap(seed, share):
    rng = np.random.default_rng(seed)
    events = plan.events(250, PERSON, rng)
    changed = plan.frowning(events, share, rng)

    def of(events, *actions):
        return sorted((e for e in events if e.action in actions), key=lambda e: e.start)

    brow = of(changed, "BrowUp", "BrowDown")
    assert not any(a.meets(b) for i, a in enumerate(brow) for b in brow[i + 1 :])
    others = set(ACTIONS) - {"BrowUp", "BrowDown"}
    assert of(changed, *others) == of(events, *others)
    shapes = {(e.start, e.attack, e.hold, e.release) for e in of(events, *plan.SMILES)}
    new = [e for e in brow if e not in events]
    assert all((e.start, e.attack, e.hold, e.release) in shapes for e in new)
    assert all(
        e in changed or any(e.meets(frown) for frown in new)
        for e in of(events, "BrowUp", "BrowDown")
    )
    assert len(new) == {0: 0, 1: len(shapes)}.get(share, len(new))

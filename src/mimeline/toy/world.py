"""The world as tables: motion as a tracker sees it, and the truth about it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.toy import channels, difficulty, plan
from mimeline.toy.curves import envelope, knots_for, through_knots
from mimeline.toy.plan import Event, Person, PlannedClip
from mimeline.vocabulary import ACTIONS, CHANNELS, EXPRESSIONS, GAZE, HEAD

_ANGLES = [channels.INDEX[name] for name in (*HEAD, *GAZE)]
_COEFFICIENTS = [channels.INDEX[name] for name in EXPRESSIONS]
_LOOKS = [channels.INDEX[name] for name in EXPRESSIONS if name.startswith("eyeLook")]
_WANDER = np.array([difficulty.WANDER[name] for name in (*HEAD, *GAZE)])
_JITTER, _DRIFT = difficulty.jitter(), difficulty.drift()
_SYLLABLE = 5  # frames between two knots of the speech


@dataclass(frozen=True)
class World:
    """What happened and what a tracker saw of it.

    clips: the clips as planned. motion: table `motion`, with jitter and drift; clean: the same
    before jitter and drift. frames, intervals: tables `frames` and `intervals`, the truth: an
    action is on from the middle of its attack to the middle of its release. speech: clip_id →
    (n_frames,) in [0, 1], how far the syllables open the mouth; 0 where nobody talks.
    """

    clips: list[PlannedClip]
    motion: pd.DataFrame
    clean: pd.DataFrame
    frames: pd.DataFrame
    intervals: pd.DataFrame
    speech: dict[str, np.ndarray]


def simulate(people: int, clips: int, seed: int, smiles_frown: float = 0.0) -> World:
    """A world of so many people and clips, deterministic in the seed, without faults.

    smiles_frown: share of the smiles that come with a lowered brow.
    """
    crowd = plan.people(people, seed)
    return render(plan.clips(clips, crowd, seed), crowd, seed, smiles_frown)


def render(
    clips: Sequence[PlannedClip], people: Sequence[Person], seed: int, smiles_frown: float = 0.0
) -> World:
    """Act out planned clips."""
    by_name = {person.name: person for person in people}
    clean, noisy, truth, intervals, speech = [], [], [], [], {}
    for clip in clips:
        rng = np.random.default_rng([seed, 4, clip.index])
        person = by_name[clip.person]
        events = plan.events(clip.n_frames, person, rng)
        own = np.random.default_rng([seed, 10, clip.index])  # or a share would change all else
        events = plan.with_extra(plan.frowning(events, smiles_frown, own), clip.extra)
        events = [] if clip.deserted else events
        motion, speech[clip.clip_id] = act(events, clip.n_frames, person, clip.talks, rng)
        clean.append(motion.astype(np.float32))
        noisy.append(track(motion, rng).astype(np.float32))
        truth.append(_frames(events, clip.n_frames))
        intervals += _intervals(clip, events)
    key = _key(clips)
    return World(
        clips=list(clips),
        motion=_motion(key, noisy),
        clean=_motion(key, clean),
        frames=_sorted(pd.concat([key, _stacked(truth, list(ACTIONS), bool)], axis=1)),
        intervals=_interval_table(intervals),
        speech=speech,
    )


def act(
    events: Sequence[Event],
    n_frames: int,
    person: Person,
    talks: bool,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """The face's true motion, (n_frames, 57) in the order of CHANNELS, and its speech, (n_frames,).

    Speech in [0, 1] is how far the syllables open the mouth.
    """
    motion = np.zeros((n_frames, len(CHANNELS)))
    for event in events:
        gain = channels.GAIN[event.action] * person.reach * event.amplitude
        _add(motion, gain, event.start, event.attack, event.hold, event.release)
        if event.action in channels.ANGULAR:
            _follow(motion, event)
    every = difficulty.WANDER_FRAMES
    knots = rng.normal(size=(knots_for(n_frames, every), len(_ANGLES))) * _WANDER
    motion[:, _ANGLES] += through_knots(knots, every, n_frames)
    speech = _speak(motion, rng) if talks else np.zeros(n_frames)
    motion += person.rest
    channels.look(motion)
    for side in ("Left", "Right"):
        down = motion[:, channels.INDEX[f"eyeLookDown{side}"]]
        motion[:, channels.INDEX[f"eyeBlink{side}"]] += channels.LID_FOLLOWS * down
    motion[:, _COEFFICIENTS] = motion[:, _COEFFICIENTS].clip(difficulty.LOWEST, difficulty.HIGHEST)
    return motion, speech


def track(motion: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Motion (n, 57) as a tracker sees it: with slow drift and white jitter on every channel."""
    n = len(motion)
    knots = rng.normal(size=(knots_for(n, difficulty.DRIFT_FRAMES), len(CHANNELS))) * _DRIFT
    seen = motion + through_knots(knots, difficulty.DRIFT_FRAMES, n)
    seen += rng.normal(size=seen.shape) * _JITTER
    channels.look(seen)  # the tracker's own angles and eyeLook channels agree
    seen[:, _LOOKS] += rng.normal(size=(n, len(_LOOKS))) * difficulty.JITTER_LOOK
    seen[:, _COEFFICIENTS] = seen[:, _COEFFICIENTS].clip(difficulty.LOWEST, difficulty.HIGHEST)
    return seen


def _add(motion, gain, start, attack, hold, release) -> None:
    curve = envelope(attack, hold, release)
    first, last = max(0, start), min(len(motion), start + len(curve))
    if first < last:
        used = np.flatnonzero(gain)
        motion[first:last, used] += np.outer(curve[first - start : last - start], gain[used])


def _follow(motion: np.ndarray, event: Event) -> None:
    """The head goes a little way with the eyes, later and slower."""
    angle, sign = channels.ANGULAR[event.action]
    if angle not in channels.FOLLOWS:
        return
    size = sign * channels.HEAD_FOLLOWS * event.amplitude
    gain = channels.vector({channels.FOLLOWS[angle]: size})
    start = event.start + channels.HEAD_LAG
    _add(motion, gain, start, 2 * event.attack, event.hold, 2 * event.release)


def _speak(motion: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Syllables open the jaw, others round the lips, from some frame to some frame.

    Returns how far they open it, (n,).
    """
    n = len(motion)
    first, last = int(rng.uniform(0, 0.4) * n), int(rng.uniform(0.7, 1.0) * n)
    gate = np.zeros(n)
    gate[first:last] = envelope(8, max(1, last - first - 16), 8)[: last - first]
    count = knots_for(n, _SYLLABLE)
    closing = np.arange(count) % 2  # open and close in turn
    curves = []
    for gain in (channels.SPEECH_GAIN, channels.ROUNDING_GAIN):
        knots = rng.uniform(0.2, 1.0, count) * closing
        curves.append(gate * through_knots(knots, _SYLLABLE, n))
        motion += np.outer(curves[-1], gain)
        closing = closing * (rng.random(count) < 0.4)
    opening, _ = curves
    return opening


def _frames(events: Sequence[Event], n_frames: int) -> np.ndarray:
    on = np.zeros((n_frames, len(ACTIONS)), dtype=bool)
    order = list(ACTIONS)
    for event in events:
        first, last = event.on(n_frames)
        on[first:last, order.index(event.action)] = True
    return on


def _intervals(clip: PlannedClip, events: Sequence[Event]) -> list[tuple]:
    found = []
    for event in events:
        first, last = event.on(clip.n_frames)
        if first < last:
            track = ACTIONS[event.action].track
            found.append((clip.clip_id, track, event.action, first, last))
    return found


def _key(clips: Sequence[PlannedClip]) -> pd.DataFrame:
    lengths = [clip.n_frames for clip in clips]
    names = np.repeat(np.array([clip.clip_id for clip in clips], dtype=object), lengths)
    frame = np.concatenate([np.arange(length) for length in lengths] or [np.empty(0, int)])
    return pd.DataFrame({"clip_id": pd.array(names, dtype="str"), "frame": frame})


def _stacked(parts: list[np.ndarray], names: list[str], dtype) -> pd.DataFrame:
    rows = np.concatenate(parts) if parts else np.empty((0, len(names)), dtype)
    return pd.DataFrame(rows, columns=names)


def _motion(key: pd.DataFrame, parts: list[np.ndarray]) -> pd.DataFrame:
    facts = pd.DataFrame(
        {"valid": True, "confidence": np.nan, "tracker_loss": np.nan}, index=key.index
    )
    return _sorted(pd.concat([key, facts, _stacked(parts, list(CHANNELS), np.float32)], axis=1))


def _sorted(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.sort_values(["clip_id", "frame"], kind="stable", ignore_index=True)


def _interval_table(rows: list[tuple]) -> pd.DataFrame:
    found = pd.DataFrame(rows, columns=["clip_id", "track", "action", "start_frame", "end_frame"])
    found = found.assign(side=pd.array([None] * len(found), dtype="str"), source="human")
    found = found.assign(cluster=pd.array([None] * len(found), dtype="Int64"), confidence=1.0)
    found = found[tables.INTERVALS.schema.names]
    return found.sort_values(["clip_id", "track", "start_frame"], kind="stable", ignore_index=True)

"""Who is there, in which clips, and what they do when: everything but the curves."""

from dataclasses import dataclass, field, replace

import numpy as np

from mimeline.toy import difficulty
from mimeline.toy.curves import on_frames
from mimeline.vocabulary import ACTIONS, CHANNELS

FPS = 30
FRAMES = (153, 298)  # a little inside 5-10 s, so that rounded catalogue times stay inside as well
ID_LETTERS = np.array(list("ABCDEFGHJKLMNPQRSTUVWXYZabcdefghijkmnopqrstuvwxyz0123456789"))


@dataclass(frozen=True)
class Person:
    """A face: where each channel rests and how far it goes, (57,) each, and how the person is."""

    name: str
    rest: np.ndarray
    reach: np.ndarray
    talks: float  # chance that a clip has speech
    blink_every: float  # frames


@dataclass(frozen=True)
class Event:
    """A planted action. start is the first frame of the attack, within the clip or before it."""

    action: str
    start: int
    attack: int
    hold: int
    release: int
    amplitude: float  # coefficient, or radians

    @property
    def end(self) -> int:
        return self.start + self.attack + self.hold + self.release

    def meets(self, other: "Event") -> bool:
        """Whether the two share a frame."""
        return self.start < other.end and other.start < self.end

    def on(self, n_frames: int) -> tuple[int, int]:
        """The half-open interval of the clip's frames that reach half the amplitude."""
        first, last = on_frames(self.attack, self.hold, self.release)
        return tuple(min(n_frames, max(0, self.start + at)) for at in (first, last))


@dataclass(frozen=True)
class PlannedClip:
    """A clip of a source video: frames [start_frame, start_frame + n_frames) of it."""

    clip_id: str
    person: str
    source: str
    index: int  # with the world's seed, where all of the clip's randomness comes from
    fps: int
    start_frame: int
    n_frames: int
    bbox: tuple[int, int, int, int]  # top, bottom, left, right; pixels
    talks: bool
    catalogue_actions: tuple[str, ...] = ()  # named in the catalogue beside those that are acted
    extra: tuple[Event, ...] = field(default=())  # events that a fault adds
    deserted: bool = False  # nobody is there


_PAUSE, _LONG_PAUSE = (12, 110), (30, 200)  # frames between two actions of a track
_FACE, _TURN = (5, 9), (6, 11)  # frames of attack and release


@dataclass(frozen=True)
class _Habit:
    """How a track is filled: which actions how often, and frames (low, high) of each phase."""

    actions: dict[str, float]
    pause: tuple[int, int]
    ramp: tuple[int, int]
    hold: tuple[int, int]


HABITS = {
    "brow": _Habit({"BrowUp": 0.55, "BrowDown": 0.45}, _PAUSE, _FACE, (20, 80)),
    "lid": _Habit({"EyeSquint": 0.55, "EyeWiden": 0.45}, _PAUSE, _FACE, (20, 80)),
    "mouth": _Habit({"SoftSmile": 0.36, "Smile": 0.34, "MouthFrown": 0.3}, _PAUSE, _FACE, (25, 90)),
    "gaze_h": _Habit({"GazeLeft": 0.5, "GazeRight": 0.5}, _LONG_PAUSE, (3, 6), (15, 60)),
    "gaze_v": _Habit({"GazeUp": 0.4, "GazeDown": 0.6}, _LONG_PAUSE, (3, 6), (15, 50)),
    "head_h": _Habit({"HeadLeft": 0.5, "HeadRight": 0.5}, _LONG_PAUSE, _TURN, (20, 70)),
    "head_v": _Habit({"HeadUp": 0.45, "HeadDown": 0.55}, _LONG_PAUSE, _TURN, (20, 60)),
}
SMILES = ("SoftSmile", "Smile")
LONG_CLOSURE = 0.12  # share of the blinks that stay closed


def people(count: int, seed: int) -> list[Person]:
    """People with resting values, reach and asymmetry of their own, the same in any count."""
    return [_person(number, np.random.default_rng([seed, 1, number])) for number in range(count)]


def _person(number: int, rng: np.random.Generator) -> Person:
    mean = difficulty.rest()
    offset = np.clip(rng.normal(0, 0.12, len(CHANNELS)), -0.3, 0.3) * mean
    bias = np.array([0.0 if c.kind == "expression" else 0.02 for c in CHANNELS.values()])
    resting, reach = mean + offset + bias * rng.normal(size=len(CHANNELS)), np.ones(len(CHANNELS))
    names = list(CHANNELS)
    for position, name in enumerate(names):
        if name.endswith("Right") and name.removesuffix("Right") + "Left" in CHANNELS:
            left = names.index(name.removesuffix("Right") + "Left")
            resting[position] = resting[left] * rng.uniform(0.92, 1.08)
            reach[position] = rng.uniform(0.94, 1.06)
    reach *= rng.uniform(0.94, 1.06)
    return Person(
        f"person{number:03d}", resting, reach, rng.uniform(0.5, 0.95), rng.uniform(70, 140)
    )


def clips(count: int, people: list[Person], seed: int) -> list[PlannedClip]:
    """Clips in turn over the people, two source videos each, times apart within a source."""
    planned, used = [], {}
    for index in range(count):
        rng = np.random.default_rng([seed, 2, index])
        number = index % len(people)
        part = int(rng.integers(2))
        source = _source_id(seed, number, part)
        take, free = used.get(source, (0, int(rng.integers(0, 900)) * 7))
        n_frames = int(rng.integers(*FRAMES, endpoint=True))
        side, top, left = (int(v) for v in rng.integers((540, 0, 100), (700, 60, 500)))
        planned.append(
            PlannedClip(
                clip_id=f"{source}_{take}_0",
                person=people[number].name,
                source=source,
                index=index,
                fps=FPS,
                start_frame=free,
                n_frames=n_frames,
                bbox=(top, top + side, left, left + side),
                talks=bool(rng.random() < people[number].talks),
            )
        )
        used[source] = take + 1, free + n_frames + int(rng.integers(240, 1200))
    return planned


def _source_id(seed: int, person: int, part: int) -> str:
    rng = np.random.default_rng([seed, 3, person, part])
    return "".join(rng.choice(ID_LETTERS, 11))


def events(n_frames: int, person: Person, rng: np.random.Generator) -> list[Event]:
    """What a person does in a clip: the seven acted tracks and the closures."""
    acted = []
    for habit in HABITS.values():
        acted += _acted(habit, n_frames, rng)
    return acted + _closures(n_frames, person, rng)


def _acted(habit: _Habit, n_frames: int, rng: np.random.Generator) -> list[Event]:
    events, actions, chances = [], list(habit.actions), list(habit.actions.values())
    at = int(rng.integers(-habit.hold[1], habit.pause[1] // 2))
    while at < n_frames:
        action = actions[rng.choice(len(actions), p=chances)]
        attack, release = (int(v) for v in rng.integers(*habit.ramp, size=2, endpoint=True))
        variants = difficulty.AMPLITUDE[action]
        low, high, _ = variants[rng.choice(len(variants), p=[v[2] for v in variants])]
        hold = int(rng.integers(*habit.hold, endpoint=True))
        event = Event(action, at, attack, hold, release, float(rng.uniform(low, high)))
        events.append(event)
        at = event.end + int(rng.integers(*habit.pause, endpoint=True))
    return [event for event in events if event.end > 0]


def _closures(n_frames: int, person: Person, rng: np.random.Generator) -> list[Event]:
    events, at = [], int(rng.integers(0, person.blink_every))
    while at < n_frames:
        long = rng.random() < LONG_CLOSURE
        attack, release = (3, 4) if long else (int(rng.integers(1, 3)), int(rng.integers(2, 4)))
        hold = int(rng.integers(12, 40)) if long else int(rng.integers(1, 3))
        amplitude = float(rng.uniform(*difficulty.CLOSURE))
        events.append(Event("EyeClose", at, attack, hold, release, amplitude))
        at = events[-1].end + 6 + int(rng.exponential(person.blink_every))
    return events


def frowning(events: list[Event], share: float, rng: np.random.Generator) -> list[Event]:
    """Events of which that share of the smiles come with a lowered brow for as long.

    What else the brow does at that time gives way.
    """
    low, high, _ = difficulty.AMPLITUDE["BrowDown"][-1]
    frowns = []
    for smile in (event for event in events if event.action in SMILES):
        drawn, amplitude = rng.random(), float(rng.uniform(low, high))
        if drawn < share:
            frowns.append(replace(smile, action="BrowDown", amplitude=amplitude))
    kept = [
        event
        for event in events
        if ACTIONS[event.action].track != "brow" or not any(map(event.meets, frowns))
    ]
    return kept + frowns


def with_extra(events: list[Event], extra: tuple[Event, ...]) -> list[Event]:
    """Events and extra ones; on a track that an extra one uses, the others give way."""
    taken = {ACTIONS[event.action].track for event in extra}
    return [e for e in events if ACTIONS[e.action].track not in taken] + list(extra)

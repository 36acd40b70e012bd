from dataclasses import replace
from itertools import pairwise

import av
import numpy as np
import pytest

from mimeline.toy import plan, simulate, video
from mimeline.toy.appearance import appearance
from mimeline.toy.voice import RATE, voice

FPS, SAMPLES = 30, RATE / 30  # a frame's


@pytest.fixture(scope="module")
def talk():
    """How far somebody who talks opens the mouth, (n,)."""
    world = simulate(4, 12, 5)
    return next(curve for curve in world.speech.values() if curve.max() > 0.8)


def loudness(sound: np.ndarray, n_frames: int, late: float = 0.0) -> np.ndarray:
    """Root mean square of the sound in each frame, heard `late` frames later, (n_frames,)."""
    edges = np.rint((np.arange(n_frames + 1) + late) * SAMPLES).astype(int).clip(0, len(sound))
    parts = (sound[a:b] for a, b in pairwise(edges))
    return np.array([np.sqrt(np.mean(part**2)) if len(part) else 0.0 for part in parts])


def heard(path) -> np.ndarray:
    """The sound of a video as a player plays it from its start."""
    with av.open(str(path)) as film:
        parts = [(frame.time, frame.to_ndarray().mean(axis=0)) for frame in film.decode(audio=0)]
    starts, sounds = zip(*parts, strict=True)
    return np.concatenate([np.zeros(round(starts[0] * RATE)), *sounds])


def test_a_voice_is_as_loud_as_the_mouth_is_open(talk):
    sound = voice(talk, FPS, 120.0, np.random.default_rng(0))
    assert sound.dtype == np.float32
    assert len(sound) == round(len(talk) * SAMPLES)
    assert 0.2 < np.abs(sound).max() <= 1
    on = talk > 0
    assert np.corrcoef(loudness(sound, len(talk))[on], talk[on])[0, 1] > 0.98


def test_a_still_mouth_is_silent(talk):
    sound = voice(talk, FPS, 120.0, np.random.default_rng(0))
    still = np.convolve(talk > 0, [1, 1, 1], "same") == 0  # and so are its neighbours
    assert still.sum() > 10
    assert (loudness(sound, len(talk))[still] == 0).all()
    assert not voice(np.zeros(60), FPS, 120.0, np.random.default_rng(0)).any()


@pytest.mark.parametrize("pitch", [85.0, 130.0, 230.0])
def test_a_voice_has_the_pitch_asked_for(pitch):
    sound = voice(np.full(150, 0.8), FPS, pitch, np.random.default_rng(1))
    found = []
    for start in range(RATE // 2, len(sound) - 2048, 2048):
        part = sound[start : start + 2048]
        likeness = np.correlate(part, part, "full")[2047:]
        low, high = int(RATE / (1.5 * pitch)), int(RATE / (0.6 * pitch))
        found.append(RATE / (low + likeness[low:high].argmax()))
    assert np.median(found) == pytest.approx(pitch, rel=0.12)
    assert np.std(found) > 0.01 * pitch  # a melody


def test_an_open_jaw_raises_the_first_formant():
    def heaviest(opening: float) -> float:
        sound = voice(np.full(150, opening), FPS, 100.0, np.random.default_rng(1))
        power = np.abs(np.fft.rfft(sound)) ** 2
        hertz = np.fft.rfftfreq(len(sound), 1 / RATE)
        low = (hertz > 150) & (hertz < 1000)
        return (power[low] * hertz[low]).sum() / power[low].sum()

    assert heaviest(1.0) > heaviest(0.1) + 200


def test_sound_and_picture_of_a_video_are_in_step(tmp_path):
    world = simulate(4, 12, 5)
    clip = next(c for c in world.clips if world.speech[c.clip_id].max() > 0.8)
    motion = world.clean[world.clean["clip_id"] == clip.clip_id]
    speech, n = world.speech[clip.clip_id], clip.n_frames
    path = tmp_path / "talk.mp4"
    video.shoot(
        path,
        clip,
        looks=appearance(0, 5),
        motion=motion,
        speech=speech,
        covered=np.zeros(n, bool),
        shown=np.arange(n),
        size=64,
        seed=5,
    )
    sound, jaw, on = heard(path), motion["jawOpen"].to_numpy(), speech > 0
    lags = np.arange(-8, 9) / 4  # frames
    likeness = [np.corrcoef(loudness(sound, n, lag)[on], jaw[on])[0, 1] for lag in lags]
    assert likeness[8] > 0.95
    assert abs(lags[np.argmax(likeness)]) < 1


def test_who_does_not_talk_is_silent_in_the_video(tmp_path):
    crowd = plan.people(1, 0)
    clip = replace(plan.clips(1, crowd, 0)[0], n_frames=30, deserted=True)
    video.shoot(
        tmp_path / "still.mp4",
        clip,
        looks=appearance(0, 0),
        motion=simulate(1, 1, 0).clean.iloc[:30],
        speech=np.zeros(30),
        covered=np.zeros(30, bool),
        shown=np.arange(30),
        size=64,
        seed=0,
    )
    assert np.abs(heard(tmp_path / "still.mp4")).max() < 1e-4

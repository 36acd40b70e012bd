"""Speech-like sound: a voice that says nothing, as loud as the mouth is open.

Glottal pulses and a little breath pass through formant resonators (Klatt 1980, figure 5: a cascade
of second-order sections); the jaw leads the first formant.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import sosfilt

from mimeline.toy.curves import knots_for, through_knots

RATE = 16_000
BLOCK = 80  # samples with the same formants: 5 ms
LEVEL = 0.22  # root mean square of a wide open mouth's sound
PEAK = 0.98
LEVEL_S = 0.024  # over which the level is evened out before the mouth sets it

INTONATION, INTONATION_S = 0.12, 0.4  # share of the pitch, seconds between two turns
FLUTTER, FLUTTER_S = 0.015, 0.05
OPENED, CLOSING = 0.45, 0.2  # shares of a period in which the glottis opens and closes
BREATH = 0.03

F1_CLOSED, F1_OPEN = 280.0, 780.0  # Hz, by the jaw
F2, F2_S = (950.0, 2000.0), 0.24  # Hz, seconds between two places of the tongue
F3, F4 = 2550.0, 3500.0
BANDWIDTHS = np.array([70.0, 100.0, 160.0, 240.0])
USUAL_PITCH, HIGHER = 120.0, 0.15  # Hz; share by which the formants rise with an octave


def voice(speech: np.ndarray, fps: int, pitch_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Sound of speech (n_frames,) in [0, 1]: how far the mouth is open in each frame.

    Returns (n_frames / fps * RATE,) float32 in [-1, 1]; its level follows speech from the middle
    of one frame to that of the next, and it is silent where speech is 0.
    """
    count = round(len(speech) / fps * RATE)
    if not speech.any():
        return np.zeros(count, np.float32)
    at = np.arange(count) / RATE * fps - 0.5  # in frames
    opening = np.interp(at, np.arange(len(speech)), speech)  # (count,)
    source = _pulses(_pitch(count, pitch_hz, rng)) + BREATH * rng.normal(size=count)
    sound = _resonate(source, _formants(opening[::BLOCK], pitch_hz, rng))
    level = np.sqrt(uniform_filter1d(sound**2, round(LEVEL_S * RATE)))
    sound = LEVEL * opening * sound / np.maximum(level, 1e-9)
    return (sound * min(1.0, PEAK / np.abs(sound).max())).astype(np.float32)


def _wander(every_s: float, count: int, rate: float, rng: np.random.Generator) -> np.ndarray:
    """A smooth random curve in [-1, 1], (count,) at rate per second."""
    every = every_s * rate
    return through_knots(rng.uniform(-1, 1, knots_for(count, every)), every, count)


def _pitch(count: int, pitch_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Hz at each sample: a melody, and the flutter of a living voice."""
    melody = INTONATION * _wander(INTONATION_S, count, RATE, rng)
    return pitch_hz * (1 + melody + FLUTTER * _wander(FLUTTER_S, count, RATE, rng))


def _pulses(pitch: np.ndarray) -> np.ndarray:
    """The glottis's flow, differentiated as lips radiate it (Rosenberg 1971, pulse C)."""
    phase = np.cumsum(pitch / RATE) % 1
    opening = (1 - np.cos(np.pi * phase / OPENED)) / 2
    closing = np.cos(np.pi / 2 * (phase - OPENED) / CLOSING)
    flow = np.where(phase < OPENED, opening, np.where(phase < OPENED + CLOSING, closing, 0.0))
    return np.diff(flow, prepend=flow[0]) * RATE / pitch / 10


def _formants(opening: np.ndarray, pitch_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Hz of the four formants by block, (blocks, 4), of the mouth's opening (blocks,)."""
    tongue = (1 + _wander(F2_S, len(opening), RATE / BLOCK, rng)) / 2
    first = F1_CLOSED + (F1_OPEN - F1_CLOSED) * opening
    second = F2[0] + (F2[1] - F2[0]) * tongue
    still = np.ones_like(opening)
    shorter = 1 + HIGHER * np.log2(pitch_hz / USUAL_PITCH)  # a higher voice has a shorter tract
    return shorter * np.column_stack([first, second, F3 * still, F4 * still])


def _resonate(source: np.ndarray, formants: np.ndarray) -> np.ndarray:
    """Source (count,) through resonators at formants (blocks, 4), Hz (Klatt 1980, eq. 1, 2)."""
    radius = np.exp(-np.pi * BANDWIDTHS / RATE)
    b = 2 * radius * np.cos(2 * np.pi * formants / RATE)  # (blocks, 4)
    c = np.broadcast_to(-(radius**2), b.shape)
    none, one = np.zeros_like(b), np.ones_like(b)
    sections = np.stack([1 - b - c, none, none, one, -b, -c], axis=-1)  # (blocks, 4, 6)
    out, state = np.empty_like(source), np.zeros((len(BANDWIDTHS), 2))
    for block, section in enumerate(sections):
        part = slice(block * BLOCK, (block + 1) * BLOCK)
        out[part], state = sosfilt(section, source[part], zi=state)
    return out

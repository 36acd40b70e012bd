"""Motion that a model makes of timelines, as long as they are."""

from copy import deepcopy
from fractions import Fraction

import numpy as np
import pytest
import torch

from mimeline.dataset.windows import Normaliser
from mimeline.generation.timeline import Sampling
from mimeline.models.timeline import TimelineModel
from mimeline.motion.generated import TooLong, generated, in_windows, origins_of, poor, refuse_long
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.tracking.take import Origin
from mimeline.training.checkpoint import Trained

NAMES = ("browInnerUp", "mouthSmileLeft", "head_yaw_left")
SAMPLING = Sampling("ddim", 2, 1.0, {}, (0, 1), 0.25, "float32")


@pytest.fixture(scope="module")
def trained() -> Trained:
    """A small model that never learnt, of 25 frames per second and windows of 20."""
    torch.set_num_threads(1)
    model = TimelineModel(NAMES, 16, 2, 1, 1, "halves", "initial", "cosine", 20)
    generator = torch.Generator().manual_seed(0)
    model = model.eval().requires_grad_(False)
    for parameter in model.parameters():
        parameter.copy_(torch.randn(parameter.shape, generator=generator) * 0.3)
    normaliser = Normaliser(NAMES, *(np.full(3, x) for x in (0.4, 0.2, 0, 1)))
    origins = {
        "browInnerUp": Origin("column BrowInnerUp"),
        "mouthSmileLeft": Origin("expression through a face", quality=0.3),
    }
    return Trained("timeline", model, normaliser, {"window": 20}, Fraction(25), origins)


def smile(fps, frames: int, name: str = "x") -> Timeline:
    tracks = {"mouth": [Interval("Smile", 2, frames // 2)], "brow": []}
    return Timeline(name, Fraction(fps), frames, tracks)


@pytest.mark.parametrize("fps", [25, 24, 60, Fraction(30_000, 1001)])
def test_a_motion_is_as_long_as_its_timeline_at_its_rate(trained, fps):
    for frames in (1, 3, 61):
        own = smile(fps, frames) if frames > 4 else Timeline("x", Fraction(fps), frames, {})
        (motion,) = generated(trained, [own], None, SAMPLING, 0, {})
        assert len(motion) == frames and motion.fps == fps and motion.timeline == own
        assert motion.moved == list(NAMES)


def test_the_rate_of_the_motion_can_be_another(trained):
    (motion,) = generated(trained, [smile(30, 60)], Fraction(60), SAMPLING, 0, {"by": "me"})
    assert motion.fps == 60 and len(motion) == 120
    assert [(own.start, own.end) for own in motion.timeline] == [(4, 60)]
    assert motion.made["by"] == "me" and motion.made["seed"] == 0
    assert motion.made["sampling"]["sampler"] == "ddim"


def test_the_model_is_asked_at_its_own_rate(trained):
    """So a timeline of twice the rate has the same motion, twice as fine."""
    (plain,) = generated(trained, [smile(25, 30)], None, SAMPLING, 0, {})
    fine = Timeline("x", Fraction(50), 60, {"mouth": [Interval("Smile", 4, 30)], "brow": []})
    (twice,) = generated(trained, [fine], None, SAMPLING, 0, {})
    names = list(NAMES)
    np.testing.assert_allclose(twice.frames[names][::2], plain.frames[names], atol=1e-6)


def test_each_channel_is_no_surer_than_what_it_was_learnt_from(trained):
    origins = origins_of(trained)
    assert origins["mouthSmileLeft"].quality == 0.3
    assert "made by a model" in origins["mouthSmileLeft"].text
    assert "expression through a face" in origins["mouthSmileLeft"].text
    assert origins["browInnerUp"].quality is None
    assert origins["head_yaw_left"] == Origin("made by a model")
    assert origins["tongueOut"] == Origin("not made by the model", measured=False)
    assert poor(trained) == "learnt with a quality below 0.5: mouthSmileLeft (0.3)"
    assert poor(Trained(*list(vars(trained).values())[:-1], {})) == ""


def test_what_is_longer_than_the_window_is_told_and_can_be_refused(trained):
    within, longer = smile(50, 40), smile(50, 42, "long")
    refuse_long([within], trained)
    assert in_windows([within], trained) == ""
    assert in_windows([longer], trained).startswith("longer than the 20 frames (0.8 s)")
    assert in_windows([within, longer], trained).startswith("1 of 2 longer than")
    with pytest.raises(TooLong, match=r"clip long: found 21 frames \(0.84 s\)"):
        refuse_long([within, longer], trained)


def test_the_model_that_was_read_stays_as_it_was(trained):
    before = deepcopy(trained.model.state_dict())
    rough = Sampling("ddim", 2, 1.0, {}, (0, 1), 0.25, "bfloat16")
    [*generated(trained, [smile(25, 10)], None, rough, 0, {})]
    after = trained.model.state_dict()
    assert all(torch.equal(before[name], after[name]) for name in before)
    assert all(
        value.dtype == torch.float32 for value in after.values() if value.is_floating_point()
    )

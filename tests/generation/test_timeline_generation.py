import numpy as np
import pytest

from mimeline.generation.timeline import PAIRS, batches, generate
from mimeline.training.checkpoint import BadCheckpoint


def asked(*lengths):
    rng = np.random.default_rng(0)
    return [rng.integers(0, 2, (length, 16)).astype(float) for length in lengths]


def test_each_timeline_gets_motion_of_its_own_length(checkpoint):
    made = generate(checkpoint, asked(5, 12, 1), sampler_steps=4, guidance=2.0, seed=0)
    assert [clip.shape for clip in made] == [(5, 3), (12, 3), (1, 3)]
    assert all(np.isfinite(clip).all() for clip in made)


def test_motion_stays_within_what_training_has_seen(checkpoint):
    made = np.concatenate(generate(checkpoint, asked(60), sampler_steps=4, guidance=8.0, seed=0))
    assert (made >= [0.0, 0.0, -0.5]).all()
    assert (made <= [1.0, 1.0, 0.5]).all()


def test_a_seed_settles_the_motion(checkpoint):
    one, two, other = (generate(checkpoint, asked(9), 4, 2.0, seed)[0] for seed in (3, 3, 4))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)


def test_the_timeline_and_the_guidance_matter(checkpoint):
    (timeline,) = asked(9)
    base = generate(checkpoint, [timeline], 4, 1.0, 0)[0]
    assert not np.allclose(base, generate(checkpoint, [1 - timeline], 4, 1.0, 0)[0])
    assert not np.allclose(base, generate(checkpoint, [timeline], 4, 3.0, 0)[0])


def test_where_nothing_is_asked_for_guidance_changes_nothing(checkpoint):
    free = [np.full((9, 16), -1.0)]
    first, second = (generate(checkpoint, free, 4, scale, 0)[0] for scale in (1.0, 3.0))
    assert first == pytest.approx(second, abs=1e-5)


def test_no_timeline_gives_no_motion(checkpoint):
    assert generate(checkpoint, [], 4, 2.0, 0) == []


def test_a_missing_checkpoint_is_a_typed_error(tmp_path):
    with pytest.raises(BadCheckpoint):
        generate(tmp_path / "nowhere", asked(3), 4, 2.0, 0)


def test_a_timeline_s_motion_does_not_depend_on_its_company(checkpoint):
    first, *others = asked(9, 14, 5)
    alone = generate(checkpoint, [first], 4, 2.0, 0)[0]
    among = generate(checkpoint, [first, *others], 4, 2.0, 0)[0]
    assert among == pytest.approx(alone, abs=1e-4)


def test_long_timelines_go_in_batches_of_their_own():
    lengths = [100, 3000, 2000, 100]
    found = list(batches(lengths))
    assert sorted(i for batch in found for i in batch) == [0, 1, 2, 3]
    assert found[0] == [1]
    assert all(len(b) == 1 or len(b) * max(lengths[i] for i in b) ** 2 <= PAIRS for b in found)

import safetensors.torch
import torch

from mimeline.training.checkpoint import losses


def test_training_lowers_the_loss(trained):
    rows = losses(trained)
    assert rows["loss"].tail(10).mean() < 0.8 * rows["loss"].head(10).mean()
    assert rows["val_loss"].iloc[-1] < 0.8 * rows["val_loss"].iloc[0]


def test_a_seed_settles_the_weights(world, trained, tmp_path):
    def weights(folder):
        return safetensors.torch.load_file(folder / "model.safetensors")

    first, again = weights(trained), weights(world.train(tmp_path / "again"))
    assert first.keys() == again.keys()
    assert all(torch.equal(first[name], again[name]) for name in first)
    other = weights(world.train(tmp_path / "other", seed=1, steps=2))
    assert any(not torch.equal(first[name], other[name]) for name in first)


def test_without_a_validation_clip_there_is_no_validation_loss(unvalidated):
    rows = losses(unvalidated)
    assert len(rows) == 2
    assert rows["val_loss"].isna().all()

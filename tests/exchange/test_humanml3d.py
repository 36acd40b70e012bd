"""`mimeline dataset export --to humanml3d`: the folder that text-to-motion trainers read."""

from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.exchange.datasets import export
from mimeline.exchange.humanml3d import resampled
from mimeline.exchange.licences import Told
from mimeline.exchange.tagged import line
from mimeline.inspection.left_behind import rows_of
from mimeline.motion.motion import Motion
from mimeline.motion.resampling import resampled as of_a_motion
from mimeline.vocabulary import CHANNELS


@pytest.fixture(scope="module")
def exported(divided_once, tmp_path_factory):
    """The folder of an export of the run, and what is said of it."""
    folder = tmp_path_factory.mktemp("humanml3d") / "out"
    return folder, str(export(divided_once, "humanml3d", folder, Told()))


def loaded(folder, split: str, shortest: int = 1, too_long: int = 200) -> dict[str, tuple]:
    """What a loader of HumanML3D makes of a split: id → motion and (caption, tokens) of each text.

    As published: lines split at #, tokens at blanks, `word/TAG` in two; other lengths passed over.
    """
    found = {}
    for name in (folder / f"{split}.txt").read_text().splitlines():
        motion = np.load(folder / "new_joint_vecs" / f"{name}.npy")
        if not shortest <= len(motion) < too_long:
            continue
        texts = []
        for text in (folder / "texts" / f"{name}.txt").read_text().splitlines():
            caption, tokens, start, end = text.strip().split("#")
            assert float(start) == float(end) == 0.0  # of the whole clip
            texts.append((caption, [tuple(token.split("/")) for token in tokens.split(" ")]))
        found[name] = motion, texts
    return found


def test_a_loader_finds_motion_and_texts_of_each_clip_that_is_whole(exported):
    folder, _ = exported
    train, val = loaded(folder, "train"), loaded(folder, "val")
    assert set(train) == {"-good_0", "good_1"} and set(val) == {"other_0"}
    channels = (folder / "channels.txt").read_text().split()
    assert channels == [name for name in CHANNELS if name != "tongueOut"]
    for motion, texts in (train | val).values():
        assert motion.dtype == np.float32 and motion.shape[1] == len(channels)
        assert np.isfinite(motion).all()
        assert all(len(token) == 2 and all(token) for _, tokens in texts for token in tokens)
    assert [len(train[i][0]) for i in ("-good_0", "good_1")] == [60, 50]  # 3 and 2.5 s at 20 fps
    captions = [caption for caption, _ in train["-good_0"][1]]
    assert captions == ["He smiles | nods, 2 times: 1/2", "The person smiles."]
    assert train["-good_0"][1][0][1][:3] == [("he", "PRON"), ("smiles", "OTHER"), ("nods", "OTHER")]


def test_what_is_not_whole_is_left_out_and_told(exported):
    folder, said = exported
    left_out = pd.read_csv(folder / "left_out.csv", keep_default_na=False)
    assert left_out.to_dict("records") == [
        {
            "clip_id": "gap_0",
            "part": "train",
            "reason": "frames without a face",
            "detail": "3 of 80 frames",
        },
        {"clip_id": "mute_0", "part": "train", "reason": "no text", "detail": ""},
    ]
    assert "left out 2 clips: frames without a face 1, no text 1; left_out.csv has each" in said
    lists = {n: (folder / f"{n}.txt").read_text() for n in ("train_val", "all", "test")}
    assert lists["test"] == "" and lists["train_val"] == lists["all"]
    assert not (folder / "new_joint_vecs" / "gap_0.npy").exists()
    assert "Of the 5 clips at the end, 2 are left out here" in (folder / "README.md").read_text()


def test_at_its_own_rate_motion_is_that_of_the_runs_tables(divided_once, tmp_path):
    export(divided_once, "humanml3d", tmp_path / "out", Told(), fps=Fraction(30))
    motion = rows_of(divided_once, "ingest", tables.MOTION).set_index("clip_id")
    channels = (tmp_path / "out" / "channels.txt").read_text().split()
    for clip_id in ("-good_0", "good_1"):
        got = np.load(tmp_path / "out" / "new_joint_vecs" / f"{clip_id}.npy")
        assert np.array_equal(got, motion.loc[clip_id, channels].to_numpy(np.float32))


def test_at_another_rate_it_is_what_the_house_makes_of_one_motion(divided_once):
    motion = rows_of(divided_once, "ingest", tables.MOTION)
    rows = motion[motion["clip_id"] == "other_0"].drop(columns="clip_id").reset_index(drop=True)
    channels, rate = [name for name in CHANNELS if name != "tongueOut"], Fraction(30000, 1001)
    for fps in (Fraction(20), Fraction(50), rate):
        one = of_a_motion(Motion(rows, rate), fps).frames[channels].to_numpy(np.float32)
        got = resampled(rows[channels].to_numpy(np.float32), rate, fps)
        np.testing.assert_allclose(got, one, atol=1e-6)


def test_mean_and_std_are_of_the_training_part_and_never_zero(divided, tmp_path):
    results = divided()
    path = results / "ingest" / "00" / "motion.parquet"
    still = tables.read(tables.MOTION, path).assign(noseSneerLeft=np.float32(0.25))
    tables.write(tables.MOTION, still, path)
    folder = tmp_path / "out"
    export(results, "humanml3d", folder, Told())
    motion = np.concatenate([motion for motion, _ in loaded(folder, "train").values()])
    mean, std = np.load(folder / "Mean.npy"), np.load(folder / "Std.npy")
    np.testing.assert_allclose(mean, motion.mean(axis=0), atol=1e-5)
    np.testing.assert_allclose(std, np.maximum(motion.std(axis=0), 1e-3), atol=1e-5)
    assert std.min() == np.float32(1e-3)


def test_where_no_training_clip_is_whole_nothing_is_written(mimeline, divided, tmp_path):
    results, folder = divided(), tmp_path / "out"
    path = results / "ingest" / "00" / "motion.parquet"
    motion = tables.read(tables.MOTION, path).assign(jawOpen=np.float32(np.nan))
    tables.write(tables.MOTION, motion, path)
    words = ("dataset", "export", "--results", results, "--to", "humanml3d", "-o", folder)
    found = mimeline(*words)
    assert found.code == 1 and "found no training clip that is whole" in found.err
    assert "a channel is not measured" in found.err and not folder.exists()


def test_clips_that_the_usual_loaders_pass_over_are_told_of(mimeline, divided, tmp_path):
    words = ("dataset", "export", "--to", "humanml3d", "-o", tmp_path / "out", "--fps", "100")
    found = mimeline(*words, "--results", divided())
    assert (
        "the usual loaders pass over 3 clips of 200 or more frames (such as -good_0)" in found.err
    )
    assert loaded(tmp_path / "out", "train", 40) == {}


def test_two_exports_are_the_same_to_the_byte(divided_once, tmp_path):
    for name in ("a", "b"):
        export(divided_once, "humanml3d", tmp_path / name, Told())
    paths = [p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file()]
    assert len(paths) == 18
    for path in paths:
        assert (tmp_path / "a" / path).read_bytes() == (tmp_path / "b" / path).read_bytes()


def test_no_sentence_breaks_a_line_a_caption_or_a_token():
    for text in ("a#b\nc/d e", "It's  #1\u2028 – 3/4 of\tit", "Élodie looks <up>!"):
        told = line(text)
        assert len(told.splitlines()) == 1
        caption, tokens, *times = told.split("#")
        assert caption and times == ["0.0", "0.0"]
        assert all(len(token.split("/")) == 2 for token in tokens.split(" "))
    assert line("# / – \n") == ""
    assert line("The 2 eyes").split("#")[1] == "the/DET 2/NUM eyes/OTHER"

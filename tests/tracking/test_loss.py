from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline.errors import BadFile, MimelineError, MissingColumn
from mimeline.tracking import loss
from mimeline.tracking.take import Take, assemble

FRAMES = 40


@pytest.fixture
def take() -> Take:
    channels = pd.DataFrame({"jawOpen": np.linspace(0, 1, FRAMES)})
    valid = np.ones(FRAMES, bool)
    return Take(assemble(np.arange(FRAMES), valid, channels, 0.9, Path("a.csv")), Fraction(25))


def test_a_table_beside_a_file_tells_the_loss(take, tmp_path):
    path = tmp_path / "a.b.csv"
    (tmp_path / "a.b.loss.csv").write_text("loss, frame\n0.5,3\n\n 0.25,0\n,1\nnan,4\n")
    told = loss.with_loss(take, path, None)
    assert told.loss == loss.OWN
    assert told.motion["tracker_loss"].head(5).fillna(-1).tolist() == [0.25, -1, -1, 0.5, np.inf]
    assert told.motion["tracker_loss"].isna().sum() == FRAMES - 3


def test_a_table_in_a_folder_wins_over_the_trackers_log(take, tmp_path):
    (tmp_path / "train.log").write_text("... - Color [frame 0000] = a=1 all_loss=7.0\n")
    assert loss.with_loss(take, tmp_path, None).motion["tracker_loss"][0] == 7
    (tmp_path / "loss.csv").write_text("frame,loss\n0,0.5\n")
    assert loss.with_loss(take, tmp_path, None).motion["tracker_loss"][0] == 0.5


def test_without_a_sidecar_a_loss_from_landmarks_stays(take, tmp_path):
    known = replace(take, loss=loss.REPROJECTION, motion=take.motion.assign(tracker_loss=0.01))
    assert loss.with_loss(known, tmp_path / "a.csv", 0.7) is known
    (tmp_path / "a.loss.csv").write_text("frame,loss\n0,0.5\n")
    assert loss.with_loss(known, tmp_path / "a.csv", None) is known  # its own has no limit
    told = loss.with_loss(known, tmp_path / "a.csv", 0.7)
    assert told.loss == loss.OWN
    assert told.motion["tracker_loss"].notna().sum() == 1


LOG = """2024-01-01 10:00:00.000 | INFO     | __main__:optimize_color:412 - {line}
"""


@pytest.mark.parametrize("folder", [".", "checkpoint"])
def test_metrical_trackers_log_tells_the_last_word_on_a_frame(take, tmp_path, folder):
    lines = ["Training from beginning...", "Snapshot loaded for frame 3"]
    for frame, level, value in [(0, 0, 9.0), (0, 1, 8.0), (0, 0, 2.5), (0, 1, 1.5), (1, 1, "nan")]:
        lines.append(
            f"Color loss for level {level} [frame {frame:04d}] = loss/pho=0.1 all_loss={value}"
        )
    (tmp_path / "train.log").write_text("".join(LOG.format(line=line) for line in lines))
    (tmp_path / "checkpoint").mkdir()
    losses = loss.with_loss(take, tmp_path / folder, None).motion["tracker_loss"]
    assert losses[0] == 1.5
    assert losses[1] == np.inf  # a loss that came to nothing breaks any limit
    assert losses[2:].isna().all()


def test_a_log_without_a_loss_is_none(tmp_path):
    (tmp_path / "train.log").write_text("Training has finished...\n")
    assert loss.sidecar(tmp_path) is None


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("frame,loss\n0,high\n", "line 2"),
        ("frame,loss\n0,1\nx,1\n", "line 3"),
        ("frame,loss\n0,1\n0,2\n", "line 3"),
        ("frame,loss\n-1,1\n", "line 2"),
        ("frame,loss\n0.5,1\n", "line 2"),
        ("frame,loss\n1e30,1\n", "line 2"),
        ("frame,loss\n0,1\n41,1\n", "frame 41"),
        ("", "a.loss.csv"),
        ("\0\0\0", "a.loss.csv"),
        ('frame,loss\n"0,1\n', "a.loss.csv"),
        ("frame,loss\n0,1,2,3\n0\n", "a.loss.csv"),
        ("frame,loss,loss\n0,1,2\n", "a.loss.csv"),
    ],
)
def test_a_sidecar_that_does_not_fit_is_refused(take, tmp_path, text, place):
    (tmp_path / "a.loss.csv").write_text(text)
    with pytest.raises(MimelineError, match=place):
        loss.with_loss(take, tmp_path / "a.csv", None)


def test_a_sidecar_without_its_columns_or_in_bytes_is_refused(take, tmp_path):
    (tmp_path / "a.loss.csv").write_text("frame,error\n0,1\n")
    with pytest.raises(MissingColumn, match="found frame, error"):
        loss.sidecar(tmp_path / "a.csv")
    (tmp_path / "a.loss.csv").write_bytes(b"frame,loss\n\xff\xfe,1\n")
    with pytest.raises(BadFile):
        loss.sidecar(tmp_path / "a.csv")
    (tmp_path / "train.log").write_bytes(b"\xff[frame 0001] = all_loss=high\n")
    with pytest.raises(BadFile, match=r"train.log, line 1: found 'high'"):
        loss.sidecar(tmp_path)


def test_a_loss_that_few_frames_have_is_said_to_be_so(take):
    losses = pd.Series(0.1, index=range(FRAMES))
    for kind, limits in ((loss.OWN, (1.0, None)), (loss.REPROJECTION, (None, 1.0))):
        few = losses.where(losses.index < 10)
        some = replace(take, loss=kind, motion=take.motion.assign(tracker_loss=few))
        assert loss.not_applied(some, *limits) == "applied to the 10 of 40 frames with a loss"
        assert loss.broken(some, *limits) is None
        most = some.motion.assign(tracker_loss=losses.where(losses.index < 36))
        assert loss.not_applied(replace(some, motion=most), *limits) is None
    lost = some.motion.assign(valid=losses.index < 10)  # a frame without a face needs no loss
    assert loss.not_applied(replace(some, motion=lost), *limits) is None


def test_a_sidecar_beyond_all_bounds_is_refused_before_it_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(loss, "MOST_BYTES", 100)
    (tmp_path / "loss.csv").write_text("frame,loss\n" + "0,0.123456\n" * 10)
    with pytest.raises(BadFile, match="found 121 bytes"):
        loss.sidecar(tmp_path)


def test_one_frame_more_than_were_written_is_no_fault(take, tmp_path):
    (tmp_path / "a.loss.csv").write_text(f"frame,loss\n{FRAMES},0.5\n{FRAMES - 1},0.25\n")
    assert loss.with_loss(take, tmp_path / "a.csv", None).motion["tracker_loss"].iloc[-1] == 0.25


def with_losses(take: Take, kind: str, **at: float) -> Take:
    losses = pd.Series(0.1, index=range(FRAMES))
    for frame, value in at.items():
        losses[int(frame[1:])] = value
    return replace(take, loss=kind, motion=take.motion.assign(tracker_loss=losses))


def test_each_kind_of_loss_has_its_own_limit(take):
    own = with_losses(take, loss.OWN, f3=2.0, f9=3.0)
    facts = loss.broken(own, max_loss=1.0, max_reprojection=None)
    assert (facts["value"], facts["limit"]) == (3.0, 1.0)
    assert (facts["first_frame"], facts["last_frame"]) == (3, 9)
    assert loss.broken(own, max_loss=3.0, max_reprojection=0.01) is None
    landmarks = with_losses(take, loss.REPROJECTION, f5=0.3)
    assert loss.broken(landmarks, max_loss=0.01, max_reprojection=0.5) is None
    assert loss.broken(landmarks, max_loss=None, max_reprojection=0.2)["unit"] == "eye distances"


def test_the_ledger_can_say_why_the_rule_was_not_applied(take):
    own, landmarks = with_losses(take, loss.OWN), with_losses(take, loss.REPROJECTION)
    assert loss.not_applied(own, 1.0, None) is None
    assert loss.not_applied(landmarks, None, 1.0) is None
    for kind, limits, why in [
        (take, (1.0, 1.0), "not applied: the tracker gives no loss"),
        (own, (None, 1.0), "not applied: no limit is set: ingest.max_loss"),
        (landmarks, (1.0, None), "not applied: no limit is set: ingest.max_reprojection"),
    ]:
        assert loss.not_applied(kind, *limits) == why
        assert loss.broken(kind, *limits) is None

import json
import sys
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from mimeline.inspection.options import options
from mimeline.motion import files
from mimeline.timeline import files as timeline_files
from mimeline.timeline.timeline import Interval, Timeline

from ..directions.serving import chat, serving

SENTENCE = "smile from 1 s to 2 s, then look left"
SMILE = Timeline("me", Fraction(30), 45, {"mouth": [Interval("Smile", 10, 30)], "brow": []})


@pytest.fixture
def generate(mimeline, results, monkeypatch, tmp_path):
    """Runs `mimeline generate` on the run's model, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: mimeline("generate", "--results", results, "--model", "timeline", *words)


def motion(path):
    return files.read(path, options())


def test_a_sentence_becomes_motion_in_every_format(generate, tmp_path):
    names = ["a.csv", "a.glb", "a.npz", "a.parquet", "a.mp4", "a.obj"]
    code, out, err = generate("--text", "smile for 0.4 s", "--seconds", 1, "-o", *names)
    assert (code, out) == (0, "")
    assert "a, 1 s: Smile 0.52–0.92 s" in err and err.count("wrote ") == 6
    assert "a.csv (for Unreal, Live Link Face tools): 25 frames at 25 per second" in err
    assert (tmp_path / "a.mp4").stat().st_size > 1000
    assert len([*(tmp_path / "a").glob("*.obj")]) == 25
    numbers = [motion(tmp_path / name) for name in names[:4]]
    for own in numbers:
        assert own.fps == 25 and len(own) == 25
        assert own.moved == numbers[0].moved and len(own.moved) == 4
        np.testing.assert_allclose(own.frames[own.moved], numbers[2].frames[own.moved], atol=2e-6)


def test_where_each_channel_comes_from_travels_along(generate, tmp_path):
    generate("--text", SENTENCE, "-o", "a.csv", "a.glb", "a.npz", "a.parquet")
    for name in ("a.csv", "a.glb", "a.npz", "a.parquet"):
        found = motion(tmp_path / name)
        assert found.origins["mouthSmileLeft"].quality == 0.3
        assert "expression through a face" in found.origins["mouthSmileLeft"].text
        assert found.origins["browInnerUp"].quality is None
        assert not found.origins["tongueOut"].measured
        assert found.frames["tongueOut"].isna().all()
        assert found.made["text"] == SENTENCE and found.made["seed"] == 0
        assert [own.action for own in found.timeline] == ["Smile", "GazeLeft"]


def test_poor_channels_and_those_not_made_are_said(generate):
    err = generate("--text", SENTENCE, "-o", "a.csv")[2]
    assert "mouthSmileLeft" in err and "0.3" in err
    assert "at 0, as nothing is known of them: 53 channels" in err


def test_the_run_s_sampling_is_used_and_a_key_can_be_set(generate, tmp_path):
    generate("--text", SENTENCE, "-o", "a.npz")
    generate("--text", SENTENCE, "-o", "b.npz", "--set", "sampler_steps=4")
    steps = [motion(tmp_path / n).made["sampling"]["sampler_steps"] for n in ("a.npz", "b.npz")]
    assert steps == [3, 4]


def test_a_seed_settles_the_motion_to_the_byte(generate, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        generate("--text", SENTENCE, "-o", f"{name}.csv", "--seed", seed)
    a, b, c = ((tmp_path / f"{name}.csv").read_bytes() for name in "abc")
    assert a == b != c


@pytest.mark.parametrize("ending", [".json", ".csv", ".vtt", ".eaf", ".TextGrid", ".txt"])
def test_timelines_of_every_format_are_taken_at_their_own_rate(generate, tmp_path, ending):
    timeline_files.write(SMILE, tmp_path / f"t{ending}")
    told = ["--fps", 30, "--frames", 45] if ending in (".csv", ".txt", ".TextGrid", ".eaf") else []
    code, _, err = generate("--timeline", f"t{ending}", *told, "-o", "a.npz")
    assert code == 0, err
    found = motion(tmp_path / "a.npz")
    assert found.fps == 30 and len(found) == 45
    assert [(own.action, own.start, own.end) for own in found.timeline] == [("Smile", 10, 30)]


def test_a_rate_of_the_motion_is_not_one_of_the_timeline(generate, tmp_path):
    timeline_files.write(SMILE, tmp_path / "t.json")
    assert generate("--timeline", "t.json", "--fps", "60", "-o", "a.npz")[0] == 0
    found = motion(tmp_path / "a.npz")
    assert found.fps == 60 and len(found) == 90
    assert [(own.start, own.end) for own in found.timeline] == [(20, 60)]


def test_several_clips_get_files_of_their_own(generate, tmp_path):
    for name in ("one", "two"):
        own = Timeline(name, SMILE.fps, SMILE.n_frames, SMILE.tracks)
        timeline_files.write(own, tmp_path / f"{name}.json")
    both = ["--timeline", "one.json", "--timeline", "two.json"]
    assert generate(*both, "-o", "made", "--to", "csv,npz")[0] == 0
    names = ["one.csv", "one.mimeline.json", "one.npz", "two.csv", "two.mimeline.json", "two.npz"]
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == names
    first, second = (pd.read_csv(tmp_path / "made" / f"{name}.csv") for name in ("one", "two"))
    assert not first.equals(second)
    code, _, err = generate(*both, "-o", "a.csv")
    assert code == 1 and "found one file for 2 motions" in err
    code, _, err = generate(*both[:2], *both[:2], "-o", "twice", "--to", "csv")
    assert code == 1 and "two motions that are called one" in err


def test_what_is_there_is_not_replaced_unless_that_is_said(generate, tmp_path):
    (tmp_path / "a.csv").write_text("mine")
    code, _, err = generate("--text", SENTENCE, "-o", "a.csv")
    assert code == 1 and "a file already" in err
    assert (tmp_path / "a.csv").read_text() == "mine"
    assert generate("--text", SENTENCE, "-o", "a.csv", "--overwrite")[0] == 0
    (tmp_path / "b").mkdir()
    code, _, err = generate("--text", SENTENCE, "-o", "b.obj")
    assert code == 1 and "b already" in err


def test_a_timeline_longer_than_the_window_is_said_to_be_made_in_windows(generate):
    err = generate("--text", SENTENCE, "-o", "a.npz")[2]
    assert "longer than the 32 frames (1.3 s) that the model was trained on" in err
    err = generate("--text", "smile for 0.2 s", "--seconds", 1, "-o", "b.npz")[2]
    assert "windows" not in err


def test_a_timeline_longer_than_the_window_can_be_refused(generate, tmp_path):
    code, _, err = generate("--text", SENTENCE, "--one-window", "-o", "a.npz")
    assert code == 1 and "found 119 frames (4.76 s)" in err and "expected at most 32" in err
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--text", ""], "an empty text"),
        (["--text", "she laughs"], '"laughs"'),
        (["--text", "smile for 1 s and frown with the mouth"], "MouthFrown on mouth"),
        (["--text", "smile", "--seconds", "-1"], "--seconds: found '-1'"),
        (["--text", "smile", "--frames", "3"], "--frames: found it alone"),
        (["--text", "smile", "--endpoint", "http://x/v1"], "--language-model together"),
        (["--text", "smile", "--fps", "often"], "--fps: found 'often'"),
        (["--text", "smile", "--set", "steps=3"], "expected KEY=VALUE with one of sampler,"),
        (["--text", "smile", "--set", "sampler=euler"], "found 'euler'"),
        (["--text", "smile", "--face", "nowhere"], "nowhere: found no such file"),
        (["--timeline", "nowhere.json"], "nowhere.json: found no such file"),
    ],
)
def test_what_cannot_be_asked_is_one_line_and_leaves_nothing(generate, tmp_path, words, told):
    code, out, err = generate(*words, "-o", "a.csv")
    assert (code, out) == (1, "") and told in err
    assert err.startswith("mimeline: ") and len(err.splitlines()) == 1
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize(
    ("entries", "told"),
    [
        ([("Smile", 0, 20), ("MouthFrown", 10, 30)], "after Smile on mouth"),
        ([("Grin", 0, 20)], "Grin"),
        ([("Smile", 0, 99)], "within the clip"),
    ],
)
def test_a_bad_timeline_is_told_before_the_model_works(generate, tmp_path, entries, told):
    rows = [f"me,mouth,{action},{start},{end}\n" for action, start, end in entries]
    header = "clip_id,track,action,start_frame,end_frame\n"
    (tmp_path / "t.csv").write_text(header + "".join(rows))
    said = ["--fps", 25, "--frames", 50]
    code, _, err = generate("--timeline", "t.csv", *said, "-o", "a.csv")
    assert code == 1 and err.startswith("mimeline: t.csv, line ") and told in err
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


def test_a_model_that_is_not_there_ends_with_those_that_are(generate, mimeline, results, tmp_path):
    words = ["--text", "smile", "-o", "a.csv"]
    code, _, err = mimeline("generate", "--results", results, "--model", "talking", *words)
    assert code == 1 and "found no such model" in err and f"a model of {results}: timeline" in err
    folder = results / "train" / "timeline" / "checkpoint"
    assert mimeline("generate", "--model", folder, *words[:3], tmp_path / "b.csv")[0] == 0


def test_a_timeline_is_edited_before_it_is_made(generate, tmp_path, monkeypatch):
    editor = tmp_path / "editor.py"
    line = "EyeClose # 2.41 # 2.6 # closure\\n"
    editor.write_text(f"import sys; open(sys.argv[1], 'a').write('\\n{line}')")
    monkeypatch.setenv("VISUAL", f"{sys.executable} {editor}")
    code, _, err = generate("--text", "smile from 1 s to 2 s", "--edit", "-o", "a.npz")
    assert code == 0, err
    assert "a, 3 s: Smile 1–2 s and EyeClose 2.4–2.6 s" in err
    assert "warning" not in err
    found = motion(tmp_path / "a.npz").timeline
    assert [own.action for own in found] == ["EyeClose", "Smile"] and len(found.tracks) == 8


def test_what_an_editor_leaves_is_kept_where_it_cannot_be_used(generate, tmp_path, monkeypatch):
    editor = tmp_path / "editor.py"
    editor.write_text("import sys; open(sys.argv[1], 'w').write('Grin # 1 # 2 # mouth')")
    monkeypatch.setenv("VISUAL", f"{sys.executable} {editor}")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    code, _, err = generate("--text", "smile", "--edit", "-o", "a.npz")
    assert code == 1 and "Grin" in err
    (kept,) = tmp_path.glob("mimeline-*/timeline.txt")
    assert str(kept) in err and "Grin" in kept.read_text()


def test_any_text_goes_to_the_endpoint_that_is_named(generate, tmp_path, monkeypatch):
    monkeypatch.setenv("MIMELINE_API_KEY", "sk-secret")
    asked = ("--text", "her youth comes back to her", "--language-model", "small")
    smile = {"action": "smile", "start_s": 0.5, "end_s": 1}
    with serving(chat("no"), chat({"seconds": 1.2, "actions": [smile]})) as served:
        code, _, err = generate(*asked, "--endpoint", served.address, "-o", "a.npz")
    assert code == 0, err
    assert 'mended in the answer: action 1: "smile" taken for Smile' in err
    assert "a, 1.2 s: Smile 0.52–1 s" in err and "sk-secret" not in err
    assert served.asked[1][1]["Authorization"] == "Bearer sk-secret"
    assert motion(tmp_path / "a.npz").made["text"] == asked[1]
    code, _, err = generate(*asked, "--endpoint", served.address, "-o", "b.npz")
    assert code == 1 and "no server that answers" in err and err.count("\n") == 1
    assert not (tmp_path / "b.npz").exists()


def test_an_editor_that_fails_is_told(generate, monkeypatch, tmp_path):
    monkeypatch.setenv("VISUAL", "false")
    code, _, err = generate("--text", "smile", "--edit", "-o", "a.npz")
    assert code == 1 and "false, which ended with 1" in err and "export EDITOR" in err


def test_the_files_beside_tell_nothing_but_json(generate, tmp_path):
    generate("--text", SENTENCE, "-o", "a.csv")
    told = json.loads((tmp_path / "a.mimeline.json").read_text())
    assert told["fps"] == "25" and told["frames"] == 119
    assert told["channels"]["tongueOut"] == {
        "measured": False,
        "origin": "not made by the model",
    }

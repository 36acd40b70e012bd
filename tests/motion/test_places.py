"""Where motions are asked for."""

from pathlib import Path

import pytest

from mimeline.errors import BadFile
from mimeline.motion.places import places


def test_a_file_of_one_and_folders_of_several(tmp_path):
    one = [tmp_path / "a.csv", tmp_path / "b.glb", tmp_path / "made"]
    assert places(one, ["glb", "npz"], ["x"]) == {
        "x": [*one[:2], tmp_path / "made" / "x.glb", tmp_path / "made" / "x.npz"]
    }
    several = places([tmp_path / "made"], ["livelink"], ["x", "y"])
    assert several == {name: [tmp_path / "made" / f"{name}.csv"] for name in ("x", "y")}


@pytest.mark.parametrize(
    ("outs", "to", "names", "told"),
    [
        (["a.csv"], [], ["x", "y"], "one file for 2 motions"),
        (["made"], [], ["x"], "the format of the files in it"),
        (["made"], ["avi"], ["x"], "found 'avi'"),
        (["made"], ["csv"], ["../x"], "clip '../x'"),
        (["made"], ["csv"], ["x", "x"], "two motions that are called x"),
        (["a.avi"], [], ["x"], "ends in .avi"),
        (["there.csv"], [], ["x"], "a file already"),
        (["there.obj"], [], ["x"], "there already"),
        (["full"], ["csv", "obj"], ["x"], "x.csv and 1 more already"),
        (["file/a.csv", "file"], ["csv"], ["x"], "file: found a name without an ending"),
    ],
)
def test_what_cannot_be_written_is_told_before(tmp_path, monkeypatch, outs, to, names, told):
    monkeypatch.chdir(tmp_path)
    for name in ("there.csv", "full/x.csv", "file"):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text("mine")
    Path("there").mkdir()
    Path("full/x").mkdir()
    with pytest.raises(BadFile) as caught:
        places([Path(out) for out in outs], to, names)
    assert told in str(caught.value)


def test_what_is_there_is_replaced_where_that_is_said_but_never_the_source(tmp_path):
    there = tmp_path / "a.csv"
    there.write_text("mine")
    assert places([there], [], ["x"], overwrite=True) == {"x": [there]}
    with pytest.raises(BadFile, match="the file that is read"):
        places([there], [], ["x"], [there], overwrite=True)
    with pytest.raises(BadFile, match="the file that is read"):
        places([tmp_path], ["csv"], ["a"], [there], overwrite=True)

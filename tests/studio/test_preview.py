import re
from pathlib import Path

import numpy as np
import pytest

from mimeline import cli
from mimeline.errors import BadFile, NoSuchFile
from mimeline.exchange.reading import Reading
from mimeline.face import glb
from mimeline.face.load import load_face
from mimeline.inspection import options
from mimeline.studio.preview import Stage, preview
from mimeline.studio.previewed import CUT_SHORT, previewed
from mimeline.studio.server import HEADERS
from mimeline.timeline import files as timelines

from .previewed_files import FPS, FRAMES, HOSTILE, INVALID, TRACKED_FPS, timeline

STUDIO = Path(__file__).parents[2] / "src" / "mimeline" / "studio"
BASE, KEY = "http://127.0.0.1:8000", "the-key"
PATHS = ("/", "/files", "/motions/0", "/face/0.glb", "/static/vendor/three.js")


@pytest.fixture(scope="module")
def client(previewed_once, tmp_path_factory):
    paths = previewed_once
    shown = opened(paths.glb, paths.timelines)
    stage = Stage(shown, load_face(None), "a face", tmp_path_factory.mktemp("stage"))
    client = preview(stage, KEY).test_client()
    client.get(f"/?key={KEY}", base_url=BASE)
    return client


def opened(*paths: Path, **said):
    return previewed(paths, options(), Reading(**said))


@pytest.mark.parametrize("path", PATHS)
def test_only_who_has_the_address_sees_the_page_and_every_answer_is_sealed(client, path):
    stranger = client.application.test_client()
    answers = [client.get(path, base_url=BASE)]
    assert answers[0].status_code == 200
    answers.append(stranger.get(path, base_url=BASE))
    answers.append(client.get(path, base_url="http://evil.example"))
    answers.append(client.get(path, base_url=BASE, headers={"Sec-Fetch-Site": "cross-site"}))
    assert [answer.status_code for answer in answers[1:]] == [403, 403, 403]
    for answer in answers:
        assert {name: answer.headers.get(name) for name in HEADERS} == HEADERS


@pytest.mark.parametrize("path", ["/motions/3", "/face/3.glb", "/face/-1.glb", "/face/0", "/face/"])
def test_what_is_not_shown_is_not_there(client, path):
    assert client.get(path, base_url=BASE).status_code == 404


def test_the_page_runs_nothing_inline_and_each_button_is_heard(client):
    text = client.get("/", base_url=BASE).text
    assert not re.findall(r"<script(?![^>]*\bsrc=)|<style|\sstyle=|\son\w+=|https?://", text)
    scripts = "\n".join(path.read_text() for path in (STUDIO / "static").glob("preview*.js"))
    heard = set(re.findall(r'byId\("([\w-]+)"\)\.addEventListener\("click"', scripts))
    ids = set(re.findall(r'<button[^>]*\bid="([\w-]+)"', text))
    assert ids and ids <= heard


def test_a_motion_is_told_with_where_its_channels_come_from(client):
    told = client.get("/motions/0", base_url=BASE).json
    assert told["facts"] == ["60 frames at 30 fps, 2.00 s", "model: a model", "seed: 7"]
    channels = {channel["name"]: channel for channel in told["channels"]}
    assert channels["jawOpen"]["quality"] == 0.3 and len(channels["jawOpen"]["values"]) == FRAMES
    assert told["states"] == {"known": "made", "absent": "not made"}
    assert not channels["tongueOut"]["known"] and "values" not in channels["tongueOut"]
    assert max(channels["head_yaw_left"]["values"]) == pytest.approx(np.degrees(0.5), abs=0.5)
    assert [t["name"] for t in told["timeline"]["tracks"]] == ["brow", "closure", "mouth", "head ↔"]
    assert told["timeline"]["absent"] == ["lid", "gaze ↔", "gaze ↕", "head ↕"]


def test_each_clip_of_a_file_of_timelines_can_be_chosen(client, previewed_once):
    files = client.get("/files", base_url=BASE).json["files"]
    assert [clip["name"] for clip in files[1]["clips"]] == ["first", HOSTILE]
    assert client.get("/motions/2", base_url=BASE).json["acted"]
    assert opened(previewed_once.timelines, clip_id=HOSTILE)[0].first == 1
    with pytest.raises(BadFile, match="expected clip .*other"):
        opened(previewed_once.timelines, clip_id="other")


def test_frames_without_a_face_are_told_and_have_no_key(previewed_once, tmp_path):
    [own] = opened(previewed_once.npz)
    stage = Stage([own], load_face(None), "a face", tmp_path)
    stage.glb(0)
    file = glb.Glb(tmp_path / "0.glb")
    times = file.values(file.document["animations"][0]["samplers"][0]["input"])
    valid = [frame for frame in range(FRAMES) if frame not in INVALID]
    np.testing.assert_allclose(times, np.array(valid) / float(TRACKED_FPS), atol=1e-5)


def test_a_csv_is_told_by_its_content_and_takes_its_rate_from_the_motion_beside_it(previewed_once):
    rows = previewed_once.rows
    made, said = opened(previewed_once.glb, rows)
    assert said.clips[0].acted and not made.clips[0].acted
    assert said.clips[0].motion.fps == FPS and len(said.clips[0].motion) == FRAMES
    with pytest.raises(BadFile, match="--fps"):
        opened(rows)
    [alone] = opened(rows, fps=FPS)
    assert len(alone.clips[0].motion) == 50 and alone.clips[0].note == CUT_SHORT


@pytest.mark.parametrize(
    "name, content",
    [
        ("empty.csv", ""),
        ("empty.json", " "),
        ("other.csv", "a,b,c\n1,2,3\n"),
        ("other.json", '{"a": 1}'),
        ("broken.json", '{"tracks": '),
        ("broken.glb", "glTF"),
        ("none.json", "[]"),
        ("words.txt", "words"),
        ("film.mp4", "film"),
    ],
)
def test_what_is_neither_a_motion_nor_a_timeline_ends_with_one_line(
    mimeline, previewed_once, tmp_path, name, content
):
    path = tmp_path / name
    path.write_text(content)
    said = mimeline("preview", previewed_once.glb, path, "--no-browser")
    assert said.code == 1 and said.err.startswith(f"mimeline: {path}")
    assert len(said.err.splitlines()) == 1 and "expected" in said.err


def test_a_file_that_is_not_there_is_said_so(tmp_path):
    for name in ("none.csv", "none.json", "none.glb"):
        with pytest.raises(NoSuchFile):
            opened(tmp_path / name)


def test_a_timeline_of_no_frames_is_nothing_to_show(tmp_path):
    path = tmp_path / "nothing.json"
    empty = timeline("x").__class__("x", FPS, 0, {"brow": []})
    timelines.write(empty, path)
    with pytest.raises(BadFile, match="no frames"):
        opened(path)


def test_the_manual_names_every_option_and_key(client):
    manual = (STUDIO.parents[2] / "docs" / "preview.md").read_text(encoding="utf-8")
    offered = cli._parser()._subparsers._group_actions[0].choices["preview"].format_help()
    told = {option for option in re.findall(r"--[a-z-]+", manual) if option in offered}
    assert told == set(re.findall(r"--[a-z-]+", offered)) - {"--help"}
    help = client.get("/", base_url=BASE).text.partition('id="help"')[2].partition("</dl>")[0]
    keys = re.findall(r"<kbd>(.+?)</kbd>", help)
    assert len(keys) > 12 and not [key for key in keys if f"`{key}`" not in manual]

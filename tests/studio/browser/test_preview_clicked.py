"""The preview in a browser: what three.js draws is what the face is posed to, frame by frame."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from werkzeug.serving import make_server

from mimeline.exchange.reading import Reading
from mimeline.face.load import load_face
from mimeline.face.motion import driver, perform
from mimeline.inspection import options
from mimeline.motion import files
from mimeline.studio import server
from mimeline.studio.preview import Stage, preview
from mimeline.studio.previewed import previewed
from mimeline.vocabulary import CHANNELS

from ..previewed_files import FPS, FRAMES, HOSTILE, INVALID, TRACKED_FPS
from .tabs import Tabs, take_picture, until

METRES = 1e-4  # that a vertex may be off: a tenth of a millimetre
EVERY = 97  # vertices, of which one is looked at
READY = "mimeline.panes.length && mimeline.panes.every(({ ready }) => ready)"
VERTICES = """([pane, every]) => {
    const { face } = mimeline.panes[pane];
    const n = face.meshes[0].geometry.attributes.position.count;
    return Array.from({ length: Math.ceil(n / every) }, (_, at) => face.vertex(at * every));
}"""
CAMERAS = "mimeline.panes.map(({ face }) => face.camera.position.toArray())"
BEYOND = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


@contextmanager
def serving(folder: Path, *paths: Path) -> Iterator[str]:
    """Serves the page of files in a thread; gives its address."""
    shown = previewed(paths, options(), Reading())
    stage = Stage(shown, load_face(None), "the embedded face", folder)
    made = make_server(server.HOST, 0, preview(stage, "a-key"), threaded=True)
    made.daemon_threads = True
    thread = threading.Thread(target=made.serve_forever)
    thread.start()
    try:
        yield f"http://{server.HOST}:{made.server_port}/?{server.KEY}=a-key"
    finally:
        made.shutdown()
        thread.join()
        made.server_close()


class PreviewPage:
    """The page in a tab, when its faces are there."""

    def __init__(self, tabs: Tabs, address: str):
        self.page: Page = tabs.open(address)
        until(self.page, READY)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def frames(self) -> list[int]:
        """That each pane shows, as it says."""
        said = self.page.locator(".now b").all_inner_texts()
        return [int(text.removeprefix("frame ")) for text in said]

    def go(self, frame: int) -> None:
        """To a frame of the fastest motion, with keys."""
        self.press("Home", *["Shift+ArrowRight"] * (frame // 10), *["ArrowRight"] * (frame % 10))
        assert max(self.frames()) == frame

    def vertices(self, pane: int) -> np.ndarray:
        return np.array(self.page.evaluate(VERTICES, [pane, EVERY]))


@pytest.fixture(scope="module")
def side_by_side(previewed_once, tmp_path_factory):
    folder = tmp_path_factory.mktemp("stage")
    with serving(folder, previewed_once.glb, previewed_once.npz) as address:
        yield address


@pytest.fixture
def still(new_tabs) -> Tabs:
    return new_tabs(reduced_motion="reduce")


def test_what_three_js_draws_is_what_the_face_is_posed_to(still, side_by_side, previewed_once):
    shown = PreviewPage(still, side_by_side)
    assert shown.frames() == [0, 0]  # nothing plays by itself where motion is unwanted
    face, motion = load_face(None), files.read(previewed_once.glb, options())
    posed = perform(face, motion.frames)
    for frame in (0, 17, 42):
        shown.go(frame)
        off = np.abs(shown.vertices(0) - posed[frame, ::EVERY]).max()
        assert off < METRES, f"{off} m at frame {frame}"
    names, times = shown.page.evaluate(
        "[mimeline.panes[0].face.names, [...mimeline.panes[0].face.times]]"
    )
    assert names == list(dict.fromkeys(driver(n) or n for n in face.shape_names))
    np.testing.assert_allclose(times, np.arange(FRAMES) / float(FPS), atol=1e-6)


def test_two_motions_share_a_clock_in_seconds_and_a_camera(still, side_by_side, previewed_once):
    shown = PreviewPage(still, side_by_side)
    page = shown.page
    shown.go(30)
    assert shown.frames() == [30, 25]
    take_picture(page, "preview_two")
    expect(page.locator(".pane").nth(1).locator(".untracked")).to_be_visible()
    expect(page.locator(".pane").nth(0).locator(".untracked")).to_be_hidden()
    before = perform(load_face(None), files.read(previewed_once.npz, options()).frames)
    last = before[INVALID.start - 1, ::EVERY]
    assert np.abs(shown.vertices(1) - last).max() < METRES
    expect(page.locator(".none")).to_have_text("No timeline travels with this motion.")
    box = page.locator("canvas").first.bounding_box()
    front = page.evaluate(CAMERAS)
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 180, box["y"] + 120, steps=3)
    page.mouse.up()
    page.mouse.wheel(0, 200)
    turned = page.evaluate(CAMERAS)
    np.testing.assert_allclose(turned[0], turned[1])
    assert np.abs(np.subtract(turned, front)).max() > 0.05
    shown.press("1")
    np.testing.assert_allclose(page.evaluate(CAMERAS), front, atol=1e-9)
    shown.press("End")
    assert shown.frames() == [FRAMES - 1, FRAMES - 1]
    expect(page.locator(".now").first).to_contain_text("ended")


def test_tracks_are_scrubbed_and_say_what_is_asked(still, side_by_side):
    shown = PreviewPage(still, side_by_side)
    page = shown.page
    assert page.locator(".pane").first.locator(".track .name").all_inner_texts() == [
        "brow",
        "closure",
        "mouth",
        "head ↔",
    ]
    lanes = page.locator(".lanes").first.bounding_box()
    seconds = FRAMES / float(TRACKED_FPS)  # of the longer one
    x = lanes["x"] + (25.5 / float(FPS)) / seconds * lanes["width"]
    page.mouse.click(x, lanes["y"] + 40)
    assert shown.frames() == [25, 20]
    now = page.locator(".now").first
    for words in ("asked:", "brow up, left", "brow down, right", "smile", "head left"):
        expect(now).to_contain_text(words)
    page.mouse.move(x, lanes["y"] + 40)
    page.mouse.down()
    page.mouse.move(lanes["x"] + 1, lanes["y"] + 40)
    page.mouse.up()
    assert shown.frames() == [0, 0]
    expect(now).to_contain_text("neutral")
    shown.press("c")
    page.locator(".pane").first.get_by_role("button", name="jawOpen").click()
    expect(page.locator(".pane").first.locator('[data-curve="jawOpen"] path')).to_have_count(1)
    expect(page.locator(".pane").first.locator(".channel", has_text="tongueOut")).to_contain_text(
        "not made"
    )


def test_a_frame_between_lost_ones_has_a_stroke_as_long_as_it_is(still, previewed_once, tmp_path):
    frames = previewed_once.motion.frames.copy()
    lost = frames.index.to_series().isin([4, 6])
    frames.loc[lost, [*CHANNELS]] = np.float32(np.nan)
    frames["valid"] = ~lost
    moved = replace(previewed_once.motion, frames=frames, timeline=None)
    files.write(moved, tmp_path / "holes.npz", load_face(None))
    with serving(tmp_path, tmp_path / "holes.npz") as address:
        shown = PreviewPage(still, address)
        drawn = shown.page.locator(".curve path:not(.zero)").first.get_attribute("d")
    strokes = drawn.split("M")[1:]
    assert len(strokes) == 3 and strokes[1].endswith(f"H{6 / float(FPS):.3f}")
    assert strokes[1].startswith(f"{5 / float(FPS):.3f} ")


def test_a_timeline_alone_is_acted_and_its_clips_are_chosen_from(still, previewed_once, tmp_path):
    with serving(tmp_path, previewed_once.timelines) as address:
        shown = PreviewPage(still, address)
        page = shown.page
        expect(page.locator(".facts")).to_contain_text("acts it by rule")
        shown.go(30)
        take_picture(page, "preview_timeline")
        smiling = shown.vertices(0)
        page.locator(".clips").select_option("1")
        until(page, READY)
        expect(page.locator(".clips option:checked")).to_contain_text(HOSTILE)
        shown.go(30)
        np.testing.assert_allclose(shown.vertices(0), smiling, atol=1e-6)
        assert page.title() != "1"


def test_it_plays_stops_at_the_end_and_fits_a_phone(new_tabs, previewed_once, tmp_path):
    with serving(tmp_path, previewed_once.glb) as address:
        shown = PreviewPage(new_tabs(), address)
        page = shown.page
        shown.press("l")
        until(page, f"document.querySelector('.now b').textContent === 'frame {FRAMES - 1}'")
        expect(page.locator("#play")).to_have_text("Play")
        shown.press(" ")
        until(page, "document.querySelector('.now b').textContent !== 'frame 59'")
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate(BEYOND) <= 0
        take_picture(page, "preview_phone")


def test_without_webgl_the_tracks_are_there_and_it_says_why_the_face_is_not(still, side_by_side):
    still.context.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page = still.open(side_by_side)
    expect(page.locator(".waits").first).to_contain_text("WebGL 2")
    expect(page.locator(".act")).to_have_count(4)
    page.keyboard.press("ArrowRight")
    expect(page.locator(".now b").first).to_have_text("frame 1")

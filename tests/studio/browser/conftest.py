"""A Chromium, commands that serve pages, and small runs to look at in them."""

import os
import shutil
from fractions import Fraction
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

from mimeline.media.film import write_film

from .label_page import LabelPage
from .labelled_run import SIDE, bar_that_wanders, make
from .served import Served
from .tabs import WIDE, Tabs

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # draws what is drawn with WebGL
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
NONE = (
    f"no Chromium ({', '.join(NAMES)}) on this machine: install one to have the pages clicked "
    "through, on Debian by `apt-get install chromium`"
)


@pytest.fixture(scope="module")  # its event loop would be in the way of other modules' own
def chromium():
    """The Chromium that is installed; without one tests skip, or fail where one is required."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None and os.environ.get("MIMELINE_BROWSER") == "required":
        pytest.fail(NONE)
    if path is None:
        pytest.skip(NONE)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def new_tabs(chromium):
    """Gives Tabs of a person each. In the end, nothing may have been asked for elsewhere, and
    nothing complained of: no script's error, nothing that the content policy refused."""
    opened: list[Tabs] = []

    def new_tabs(**options) -> Tabs:
        opened.append(Tabs(chromium.new_context(viewport=WIDE, **options)))
        return opened[-1]

    yield new_tabs
    for tabs in opened:
        tabs.context.close()
        assert tabs.requested
        assert tabs.asked_elsewhere() == []
        assert tabs.complaints == []


@pytest.fixture
def tabs(new_tabs) -> Tabs:
    return new_tabs()


@pytest.fixture(scope="module")
def serve(chromium, tmp_path_factory):
    """Runs a command that serves a page until the module's tests are over."""
    running: list[Served] = []

    def serve(*words: object, **options) -> Served:
        running.append(Served(tmp_path_factory.mktemp("started"), *words, **options))
        return running[-1]

    yield serve
    for served in running:
        served.kill()


@pytest.fixture(scope="session")
def filmed(made_once, tmp_path_factory) -> Path:
    """The small run whose films are films: for a second, a bright bar wanders over the dark."""
    results = shutil.copytree(made_once, tmp_path_factory.mktemp("filmed") / "results")
    for path in results.glob("fetch/*/media/*.mp4"):
        write_film(path, bar_that_wanders(30, SIDE), Fraction(30))
    return results


@pytest.fixture(scope="session")
def drawn_once(tmp_path_factory) -> Path:
    """The small run whose clusters can be named."""
    results = tmp_path_factory.mktemp("drawn") / "results"
    make(results)
    return results


@pytest.fixture(scope="session")
def labelled_once(drawn_once, tmp_path_factory) -> Path:
    """That run without its motion: no face is drawn, which takes the longest."""
    results = tmp_path_factory.mktemp("labelled") / "results"
    return shutil.copytree(drawn_once, results, ignore=shutil.ignore_patterns("motion.parquet"))


@pytest.fixture(scope="module")
def served(serve, labelled_once, tmp_path_factory) -> Served:
    """The label page of the small run, which it does not change."""
    file = tmp_path_factory.mktemp("names") / "names.yaml"
    return serve("label", "--results", labelled_once, "--file", file=file)


@pytest.fixture
def label(served, tabs) -> LabelPage:
    """That page in a tab, as long as nobody has answered anything."""
    for file in served.file.parent.glob("names*.yaml"):
        file.unlink()
    return LabelPage(tabs.open(served.address), served.file)

import importlib.util
import re
from pathlib import Path

import cv2
import pytest

from mimeline.tracking import detectors
from mimeline.tracking.readers import READERS
from mimeline.vocabulary import CHANNELS, GAZE, HEAD

DOCS = Path(__file__).parents[2] / "docs"


def script(name: str):
    """One of the scripts that write the page, as a module."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def page() -> str:
    return (DOCS / "conventions.md").read_text(encoding="utf-8")


def test_the_page_says_what_the_readers_declare_and_the_golden_takes_hold(page):
    assert script("conventions").written(page) == page, "run: python docs/conventions.py"


@pytest.mark.parametrize("format", READERS)
def test_every_format_is_declared_in_full(format):
    convention = READERS[format].convention
    told = ("title", "files", "coefficients", "rotation", "angle_unit", "sides", "gap", "evidence")
    assert [name for name in told if not getattr(convention, name)] == []
    channels = {channel for channel, _ in convention.signs.values()} | set(convention.meanings)
    assert set(HEAD) <= channels <= set(CHANNELS)
    assert set(GAZE) <= channels or "gaze" in convention.never


def test_a_format_without_a_place_on_the_page_is_refused(page):
    with pytest.raises(ValueError, match="openface"):
        script("conventions").written(page.replace("<!-- openface -->", ""))


def test_the_page_names_every_rule_of_the_detectors(page):
    code = Path(detectors.__file__).read_text(encoding="utf-8")
    rules = re.findall(r'Finding\(\s*"(\w+)",\s*"(\w+)"', code)
    told = re.findall(r"^\| `(\w+)` \| .* \| (fail|note)", page, re.MULTILINE)
    assert len(rules) > 5 and set(rules) == set(told)


def test_links_of_the_page_lead_somewhere(page):
    targets = re.findall(r"\]\(([^)]+)\)", page)
    assert len(targets) > len(READERS)
    for target in targets:
        if target.startswith("#"):
            assert f'<a id="{target[1:]}"></a>' in page, target
        else:
            assert (DOCS / target).exists(), target


def test_the_pictures_show_what_their_captions_say():
    sheet = script("conventions_picture")
    moving = [panel for panel in sheet.PANELS if panel.motion]
    for panel in moving:
        ((channel, value),) = panel.motion.items()
        assert channel in panel.says and value > 0
        (shown,) = re.findall(r"[+−]?[\d.]+$", panel.says)
        assert float(shown.replace("−", "-")) == (-value if panel.mirrored else value)
    assert {next(iter(panel.motion)) for panel in moving} == {*HEAD, *GAZE, "eyeBlinkLeft"}


def test_the_picture_is_there_and_small():
    path = DOCS / "conventions.png"
    assert cv2.imread(str(path)).shape[1] > 1000 and path.stat().st_size < 400_000

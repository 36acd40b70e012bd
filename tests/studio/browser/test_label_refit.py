"""The label page after a refit: names that moved, and those that a person has to give anew."""

import re
import shutil
from pathlib import Path

import pytest
from playwright.sync_api import expect

from mimeline.annotation.fitted import read_fingerprint
from mimeline.annotation.label_file import (
    Answer,
    RegionAnswers,
    read_label_file,
    write_label_file,
)
from mimeline.run import remember

from .label_page import LabelPage
from .labelled_run import CONFIG, fit, propose
from .served import Served
from .tabs import take_picture

NAMES = {0: "BrowUp", 1: "Neutral", 2: "Neutral", 3: "BrowDown"}  # of the fit before
MOVED = {1: Answer("BrowDown"), 2: Answer("Neutral")}
MIN_AGREEMENT = 0.7


@pytest.fixture(scope="session")
def refitted_once(labelled_once, tmp_path_factory) -> Path:
    """The run after a refit of the brow, and names of the fit before.

    Of its three clusters the first holds the frames of two that bore other names.
    """
    results = tmp_path_factory.mktemp("refitted") / "results"
    shutil.copytree(labelled_once, results)
    model = read_fingerprint(results / "segment" / "brow" / "model")
    named = {number: Answer(action) for number, action in NAMES.items()}
    write_label_file(results.with_name("names.yaml"), {"brow": RegionAnswers(model, named)})
    shutil.rmtree(results / "segment" / "brow")
    fit(results, "brow", 3)
    propose(results)
    config = CONFIG | {"label": CONFIG["label"] | {"min_agreement": MIN_AGREEMENT}}
    remember(results, config, files=[], given=[])
    return results


@pytest.fixture(scope="module")
def served(serve, refitted_once, tmp_path_factory) -> Served:
    file = tmp_path_factory.mktemp("names") / "names.yaml"
    shutil.copy(refitted_once.with_name("names.yaml"), file)
    return serve("label", "--results", refitted_once, "--file", file=file)


@pytest.fixture
def label(served, tabs, refitted_once) -> LabelPage:
    """The page of the refitted run in a tab, with the names of the fit before."""
    shutil.copy(refitted_once.with_name("names.yaml"), served.file)
    return LabelPage(tabs.open(served.address), served.file)


def test_what_could_not_be_moved_comes_first_and_the_first_answer_writes_the_region_anew(
    label, refitted_once
):
    label.shows("brow/0")
    expect(label.page.locator("#state")).to_contain_text("Needs you")
    expect(label.page.locator("#moved-text")).to_contain_text("names moved from the fit before")
    expect(label.row("brow/1")).to_have_accessible_name(
        "brow, cluster 1: moved: Brow down 100 %, 25 % of frames"
    )
    take_picture(label.page, "label_refit")
    old = read_label_file(label.file)["brow"]
    assert {number: answer.action for number, answer in old.clusters.items()} == NAMES
    label.press("1")
    label.writes("brow/3", None)  # of the fit before
    new = read_label_file(label.file)["brow"]
    assert new.model == read_fingerprint(refitted_once / "segment" / "brow" / "model") != old.model
    assert dict(new.clusters) == {0: Answer("BrowUp")} | MOVED
    expect(label.page.locator("#moved")).to_be_hidden()
    label.press("u")
    label.writes("brow/0", None)
    assert read_label_file(label.file)["brow"].open == {0}
    expect(label.row("brow/0")).to_contain_text("needs you")


def test_moved_names_are_kept_at_once_and_the_others_stay_open(label):
    label.page.get_by_role("button", name="Keep all 2 names").click()
    label.writes("brow/3", None)
    new = read_label_file(label.file)["brow"]
    assert (new.clusters, new.open) == (MOVED, {0})
    label.shows("brow/0")
    expect(label.row("brow/0")).to_contain_text("needs you")
    label.page.reload()
    expect(label.row("brow/1")).to_have_accessible_name(
        "brow, cluster 1: named: Brow down, 25 % of frames"
    )


def test_an_answer_to_a_fit_that_is_gone_is_told_and_never_written(
    serve, tabs, labelled_once, tmp_path
):
    results = shutil.copytree(labelled_once, tmp_path / "results")
    words = ("label", "--results", results, "--file")
    served = serve(*words, file=tmp_path / "names.yaml")
    label = LabelPage(tabs.open(served.address), served.file)
    label.open("eye/1")
    shutil.rmtree(results / "segment" / "eye")
    fit(results, "eye", 3)
    propose(results)
    label.press("2")
    expect(label.page.get_by_role("alert")).to_contain_text("refitted meanwhile")
    take_picture(label.page, "label_refit_open")
    served.kill()
    again = serve(*words, file=served.file, port=served.port)
    other = LabelPage(tabs.open(again.address), served.file)  # its key counts for both tabs
    expect(label.row("eye/1")).to_have_accessible_name(re.compile("proposed"))  # refused
    other.open("brow/0")
    other.press("1")
    other.writes("brow/0", Answer("BrowUp"))
    assert set(other.written()) == {"brow/0"}
    tabs.expect("Failed to load resource: .*")

"""Whether what is made of recordings may be passed on, and who said so."""

import json

import pandas as pd
import pytest
import yaml

from mimeline.cli.datasets import LAYOUTS
from mimeline.errors import BadFile
from mimeline.exchange import datasets
from mimeline.exchange.licences import Told, data_sets, licence_of_all, of_run
from mimeline.run import Run
from mimeline.vocabulary import resource

CLIPS = pd.DataFrame({"clip_id": ["a_0", "a_1", "b_0"], "source_id": ["a", "a", "b"]})
OURS = {"data_dir": "takes", "catalogue": {"format": "files"}}
CELEBV = {"data_dir": "celebv", "catalogue": {"format": "celebvtext"}}


@pytest.fixture
def run(mimeline, divided, tmp_path):
    """Runs an export of the run under another configuration: what it said, and the folder."""

    def ask(config: dict, *words, layout: str = "huggingface"):
        results = tmp_path / "results"
        results = results if results.exists() else divided(**config)
        folder = tmp_path / "out"
        given = ("--results", results, "--to", layout, "-o", folder, *words)
        return mimeline("dataset", "export", *given), folder

    return ask


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_licence_that_forbids_to_pass_on_stops_the_export_until_it_is_named(run, layout):
    found, folder = run(CELEBV, layout=layout)
    assert found.code == 1 and not folder.exists()
    assert "data set CelebV-Text: found a licence that forbids passing on" in found.err
    assert "no portion may be copied, published or distributed" in found.err
    assert "--redistribute CelebV-Text" in found.err
    assert "https://github.com/celebv-text/CelebV-Text" in found.err
    found, folder = run(CELEBV, "--redistribute", "CelebV-Text", layout=layout)
    assert found.code == 0 and "forbids passing this on; written because of" in found.err
    card = (folder / "README.md").read_text()
    assert "**No**: its licence forbids it. Whoever made the folder overrode that" in card
    about = json.loads((folder / "about.json").read_text())
    assert about["data_sets"][0]["redistributed_all_the_same"] is True


def test_a_forbidden_data_set_is_not_freed_by_another_licence_or_name(run):
    found, folder = run(CELEBV, "--licence", "cc-by-4.0")
    assert found.code == 1 and "told: cc-by-4.0" in found.err and not folder.exists()
    found, _ = run(CELEBV, "--redistribute", "CelebV-HQ")
    assert found.code == 1 and "expected one that clips are of: CelebV-Text" in found.err


def test_recordings_of_which_nobody_tells_a_licence_are_not_written(run):
    found, folder = run(OURS)
    assert found.code == 1 and not folder.exists()
    assert "data set recordings: found no licence" in found.err
    assert "--licence recordings=cc-by-4.0" in found.err
    assert "--redistribute recordings" in found.err


def test_a_licence_that_is_told_goes_into_the_card(run):
    found, folder = run(OURS, "--licence", "CC BY 4.0", "--consent", "all signed a release")
    assert found.code == 0 and "not told, to be filled in: a contact" in found.err
    text = (folder / "README.md").read_text()
    assert yaml.safe_load(text.split("---\n")[1])["license"] == "cc-by-4.0"
    assert "- Licence: CC BY 4.0" in text
    assert "Consent of the people in it: all signed a release" in text
    assert "**no contact told** — to be filled in" in text


def test_a_licence_that_nobody_knows_and_one_without_derivatives_are_asked_about(run):
    found, _ = run(OURS, "--licence", "our own terms")
    assert (
        found.code == 1 and "the licence 'our own terms', of which nobody here knows" in found.err
    )
    found, _ = run(OURS, "--licence", "CC-BY-NC-ND 4.0")
    assert (
        found.code == 1 and "forbids passing on what is made of it (CC BY-NC-ND 4.0)" in found.err
    )


def test_what_is_not_told_stands_in_the_card_as_not_told(run):
    _, folder = run(OURS, "--redistribute", "recordings", "--data-set", "recordings")
    card = (folder / "README.md").read_text()
    assert "Nobody here knows whether the licence of recordings permits passing this on" in card
    assert "- Licence: **not told** — to be filled in" in card
    assert "**Not known**: whoever made the folder answers for it" in card
    assert "did they agree, to what, and how do they withdraw?" in card
    about = json.loads((folder / "about.json").read_text())
    assert about["data_sets"][0]["consent"] is about["data_sets"][0]["licence"] is None
    assert yaml.safe_load(card.split("---\n")[1])["license"] == "other"


def test_nothing_that_is_told_becomes_markup_or_another_line(run):
    told = "x | y <script>\n# heading"
    _, folder = run(OURS, "--licence", "mit", "--consent", told)
    card = (folder / "README.md").read_text()
    assert "x \\| y &lt;script> # heading" in card


def test_the_toy_world_is_ours_and_nobody_is_in_it(run):
    found, folder = run({})
    assert found.code == 0 and "licence of the toy world: MIT" in found.err
    assert "None: no person was recorded." in (folder / "README.md").read_text()
    assert "not told" not in found.err


def test_several_data_sets_are_told_apart_by_patterns_and_each_is_asked_about():
    told = Told(["hdtf=a_*", "mine"], ["mine=mit", "HDTF=cc-by-nc-4.0"], ["mine=all agreed"])
    hdtf, mine = data_sets(Run(OURS), CLIPS, told)
    assert (hdtf.name, hdtf.clips, hdtf.redistribution) == ("HDTF", ("a_0", "a_1"), "permitted")
    assert (mine.clips, mine.consent, mine.licence) == (("b_0",), "all agreed", "MIT")
    assert licence_of_all([hdtf, mine]) == "other" and licence_of_all([mine]) == "mit"
    assert hdtf.page and not hdtf.consent


def test_a_clip_of_no_data_set_and_words_on_none_are_errors():
    with pytest.raises(BadFile, match="no data set for clip 'b_0'"):
        data_sets(Run(OURS), CLIPS, Told(["mine=a"]))
    with pytest.raises(BadFile, match="--licence: found data set 'others', expected one that"):
        data_sets(Run(OURS), CLIPS, Told(["mine"], ["others=mit"]))
    with pytest.raises(BadFile, match="--consent"):
        data_sets(Run(OURS), CLIPS, Told(["x=a*", "y"], ["x=mit", "y=mit"], ["all agreed"]))


@pytest.mark.parametrize(
    ("config", "name"),
    [
        ({}, "recordings"),
        ({"data_dir": None, "catalogue": {"format": "celebvtext"}}, "the toy world"),
        (CELEBV, "CelebV-Text"),
        (CELEBV | {"catalogue": {"format": "ravdess"}}, "RAVDESS"),
        (OURS, "recordings"),
    ],
)
def test_the_catalogues_format_tells_the_data_set(config, name):
    assert of_run(Run(config)) == name


def test_the_table_names_a_licence_it_knows_or_says_that_it_does_not():
    table = yaml.safe_load(resource("licences.yaml").read_text())
    allowed = {"permitted", "forbidden", "unknown"}
    for own in table["data_sets"].values():
        assert own["redistribution"] in allowed
        assert own["redistribution"] != "permitted" or own["licence"] in table["licences"]
    assert {own["redistribution"] for own in table["licences"].values()} <= allowed
    assert datasets.LAYOUTS == LAYOUTS

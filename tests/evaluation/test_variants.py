import re

import pandas as pd
import pytest

from mimeline.config.sections import Ablations, TimelineModel
from mimeline.evaluation.variants import OURS, variants
from mimeline.vocabulary import resource

EVERY = Ablations().variants


def planned(wanted=EVERY, **keys):
    return variants(TimelineModel(**keys).model_dump(), wanted)


def test_table_2_is_what_is_tried_of_a_network_of_the_papers_depth():
    rows = planned(base_layers=6, branch_layers=2)
    there = {row.paper for row in rows.values()} - {""}
    table = pd.read_csv(resource("paper_ablations.csv"))
    assert there == set(table["variant"]) - {"real"}
    assert rows[OURS].paper == "Ours"
    assert rows["branch-layers-3"].changes == {"base_layers": 5, "branch_layers": 3}
    assert rows["branch-layers-3"].paper == "branchL3"
    assert rows["branch-layers-7"].paper == ""  # the paper has no such row


def test_a_papers_row_stands_beside_the_same_share_of_layers_alone():
    assert planned(base_layers=3, branch_layers=1)["branch-layers-2"].paper == "branchL4"
    assert planned(base_layers=2, branch_layers=1)["branch-layers-2"].paper == ""


@pytest.mark.parametrize("base, branch", [(2, 1), (6, 2), (0, 3), (3, 0), (1, 1)])
def test_every_variant_differs_from_the_others_and_has_as_many_layers(base, branch):
    rows = planned(base_layers=base, branch_layers=branch)
    configured = TimelineModel(base_layers=base, branch_layers=branch).model_dump()
    options = [{**configured, **row.changes} for row in rows.values()]
    assert options[0] == configured
    for number, own in enumerate(options):
        assert own not in options[:number]
        assert own["base_layers"] + own["branch_layers"] == base + branch
        assert TimelineModel(**own)


def test_what_is_configured_already_is_no_variant():
    assert "regions" not in planned(branches="regions")
    assert "carried" not in planned(timeline_tokens="carried")
    assert "no-branch" not in planned(base_layers=3, branch_layers=0)
    rows = planned(drop_each=0.3)
    assert "drop-0.3" not in rows
    assert rows["drop-0.5"].paper == "Ours"


@pytest.mark.parametrize(
    "keys",
    [
        {"drop_each": 0.3},
        {"branches": "regions"},
        {"timeline_tokens": "carried"},
        {"base_layers": 3, "branch_layers": 0},
        {"base_layers": 0, "branch_layers": 3},
    ],
)
def test_the_papers_model_stands_beside_no_model_of_other_parts(keys):
    assert planned(**keys)[OURS].paper == ""


def test_only_what_is_wanted_is_tried_beside_ours():
    assert list(planned(["no-base", "no-branch"])) == [OURS, "no-branch", "no-base"]


def test_names_are_folders_and_wildcards():
    for name in planned(base_layers=6, branch_layers=2):
        assert re.fullmatch(r"[a-z0-9][a-z0-9.-]*", name)

import pandas as pd
import pytest

from mimeline import tables
from mimeline.reporting.album import Album
from mimeline.reporting.clusters import regions
from mimeline.reporting.stand_in import stand_in


@pytest.fixture
def told(run):
    """Regions of the run; changed: of the brow's labels, cluster → columns to set."""

    def told(wanted=4, fps=30.0, kinds=(), **changed):
        given = run()
        names = tables.read(tables.LABELS, given["labels"])
        for cluster, columns in changed.items():
            at = (names["region"] == "brow") & (names["cluster"] == int(cluster[1:]))
            for column, value in columns.items():
                names[column] = names[column].astype(object)
                names.loc[at, column] = value
        tables.write(tables.LABELS, names, given["labels"])
        shown = tables.read(tables.EXEMPLARS, given["exemplars"])
        if kinds:
            first = shown[shown["region"] == "brow"].iloc[:1]
            rows = [first.assign(kind=kind, rank=rank) for rank, kind in enumerate(kinds)]
            tables.write(tables.EXEMPLARS, pd.concat(rows[::-1]), given["exemplars"])
        return regions(
            *(given[name] for name in ("series", "clusters", "labels", "exemplars", "profiles")),
            {"kept_1": fps} if fps else {},
            "left",
            wanted,
            Album({}, given["motions"], stand_in(None)),
        )

    return told


def brow(found):
    return {cluster.number: cluster for cluster in found[0].clusters}


def test_a_cluster_tells_its_name_and_shows_its_exemplars(told):
    found = told()
    cluster = found[0].clusters[0]
    assert (cluster.action, cluster.source, cluster.origin) == (
        "BrowUp",
        "human",
        "named by a person",
    )
    assert [shown.kind for shown in cluster.exemplars] == ["medoid", "longest"]
    assert cluster.exemplars[0].text == "1.00 s, frames 0–29"
    assert [shot.frame for shot in cluster.exemplars[0].shots] == [0, 14, 29]
    assert found[0].clusters[-1].action == "Neutral"


def test_exemplars_come_in_their_order_and_further_ones_where_more_are_asked_for(told):
    kinds = ("medoid", "longest", "border", "further")
    for wanted in (3, 4):
        shown = brow(told(wanted, kinds=kinds))[1].exemplars
        assert tuple(one.kind for one in shown) == kinds[:wanted]


def test_a_cluster_tells_its_size_its_purity_and_the_closest_one(told):
    assert brow(told())[1].facts == [
        "50 % of frames",
        "1 interval in 1 clip, typically 1.0 s",
        "about 96 % of it looks alike",
        "closest: 0 neutral, 2.5 nats away",
    ]
    assert "1 interval in 1 clip, typically 30 frames" in brow(told(fps=None))[1].facts


@pytest.mark.parametrize(
    ("facts", "origin"),
    [
        ({"source": "proposed", "confidence": 0.93}, "proposed by the rule, confidence 93 %"),
        ({"source": "proposed"}, "proposed by the rule"),
        (
            {"source": "moved", "confidence": 0.97},
            "moved from the fit before, 97 % of its frames bore it",
        ),
        ({"source": "proposed", "action": None, "why": "nothing fits"}, "nothing fits"),
        ({"source": "human", "action": None}, "not sure"),
    ],
)
def test_a_cluster_tells_where_its_name_is_from_or_why_it_has_none(told, facts, origin):
    found = told(_1=facts)
    assert brow(found)[1].origin == origin
    assert [c.number for c in found[0].unnamed] == ([1] if "action" in facts else [])
    assert found[0].clusters[-1].number == (1 if "action" in facts else 0)


def test_moved_names_tell_the_share_of_frames_that_kept_their_name(told):
    assert told()[0].kept is None
    moved = {"source": "moved", "confidence": 0.9, "share": 0.75}
    found = told(_0=moved, _1=moved | {"confidence": 1.0, "share": 0.25})
    assert found[0].kept == pytest.approx(0.925)

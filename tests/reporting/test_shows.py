"""What the clips show, what is told of them, and which of them are alike."""

import pandas as pd
import pytest

from mimeline import tables
from mimeline.reporting.album import Album
from mimeline.reporting.captions import captions
from mimeline.reporting.pairs import pairs
from mimeline.reporting.report import report
from mimeline.reporting.shows import MOST_BARS, RAREST, shows
from mimeline.reporting.stand_in import stand_in


@pytest.fixture
def written(tmp_path):
    """Writes rows of a table, with nothing where they say nothing; gives the path."""

    def written(table: tables.Table, rows: list[dict], reason: str = ""):
        path = tmp_path / f"{table.name}.parquet"
        tables.write(table, pd.DataFrame(rows, columns=table.schema.names), path, reason)
        return path

    return written


@pytest.fixture
def album():
    return Album({}, [], stand_in(None))


def shown(kind: str, name: str, clips: int) -> dict:
    return {"kind": kind, "attribute": name, "clips": clips, "share": clips / 1000, "seconds": 5.0}


def weights(*values: float) -> list[dict]:
    return [{"clip_id": str(n), "weight": value} for n, value in enumerate(values)]


def test_the_commonest_comes_first_and_is_told_against_the_rarest(written):
    rows = [shown("action", "yawn", 5), shown("action", "talk", 900), shown("action", "nod", 80)]
    found = shows(written(tables.ATTRIBUTES, rows), written(tables.WEIGHTS, weights(0.5, 4)), 0.5)
    assert [bar.name for bar in found.kinds[0].bars] == ["talk", "nod", "yawn"]
    assert found.imbalance == "“talk” (900 clips) is shown 180 times as often as “yawn” (5 clips)."
    assert found.weights == (0.5, 4)


def test_of_many_attributes_the_commonest_and_the_rarest_are_drawn(written):
    rows = [shown("attribute", f"a_{n}", n + 1) for n in range(40)]
    found = shows(written(tables.ATTRIBUTES, rows), written(tables.WEIGHTS, weights(1)), 0.5)
    (kind,) = found.kinds
    assert len(kind.bars) + len(kind.tail) == MOST_BARS
    assert (kind.bars[0].name, kind.tail[-1].name, len(kind.tail)) == ("a 39", "a 0", RAREST)
    assert kind.hidden == 40 - MOST_BARS
    assert found.imbalance == ""  # what holds for a whole clip is nothing to learn to show


def test_only_actions_of_ours_have_a_colour_of_their_own(written):
    rows = [shown("timeline", "BrowUp", 3), shown("action", 'x" style="', 2)]
    found = shows(written(tables.ATTRIBUTES, rows), written(tables.WEIGHTS, weights(1)), 0.5)
    assert {bar.name: bar.action for kind in found.kinds for bar in kind.bars} == {
        "brow up": "BrowUp",
        'x" style="': "",
    }


def test_a_table_without_attributes_says_why(written):
    empty = written(tables.ATTRIBUTES, [], "the catalogue tells nothing")
    assert shows(empty, written(tables.WEIGHTS, []), 0.5).reason == "the catalogue tells nothing"


def kept(clip: str, **facts) -> dict:
    nothing = {"actions": [], "emotions": [], "attributes": [], "texts": [], "shard": 0}
    times = {"start_s": 0.0, "end_s": 8.0, "fps_num": 25, "fps_den": 1, "n_frames": 200}
    blank = dict.fromkeys(tables.CLIPS.schema.names)
    return blank | {"clip_id": clip, "source_id": clip} | nothing | times | facts


def clips(*rows: dict) -> pd.DataFrame:
    return pd.DataFrame(list(rows), columns=tables.CLIPS.schema.names)


def text(clip: str, source: str, number: int = 0) -> dict:
    return {"clip_id": clip, "source": source, "number": number, "text": f"{clip} {source}"}


def test_a_text_stands_beside_what_it_is_made_from(written, album):
    smile = {"name": "smile", "start_s": 1.0, "end_s": 9.0, "uncertainty_s": 1.0}
    happy = smile | {"name": "happy", "start_s": 0.0}
    table = clips(kept("a", actions=[smile], emotions=[happy], attributes=["young"]))
    marks = {"clip_id": "a", "track": "brow", "action": "BrowUp", "source": "ticc"}
    interval = written(tables.INTERVALS, [marks | {"start_frame": 50, "end_frame": 100}])
    texts = written(tables.DESCRIPTIONS, [text("a", "catalogue"), text("a", "timeline")])
    (caption,) = captions(texts, table, [interval], album).clips
    assert caption.facts == ["young"]
    by_source = {told.source: told for told in caption.told}
    assert [row.name for row in by_source["catalogue"].rows] == ["happy", "smile"]
    assert by_source["catalogue"].rows[1].stretches[0].about == "smile: 1.0–9.0 s, each within 1 s"
    (stretch,) = by_source["timeline"].rows[0].stretches
    assert stretch.action == "BrowUp"
    first, last = caption.ticks[0], caption.ticks[-1]
    per_second = (last[0] - first[0]) / 8
    assert stretch.x == pytest.approx(first[0] + 2 * per_second, abs=0.1)
    assert stretch.width == pytest.approx(2 * per_second, abs=0.1)
    happy_row = by_source["catalogue"].rows[0].stretches[0]
    assert happy_row.x + happy_row.width <= caption.end + 0.1  # what ends later is cut off there


def test_what_nobody_timed_is_no_bar_of_the_whole_clip(written, album):
    talk = {"name": "talk", "start_s": 0.0, "end_s": 8.0, "uncertainty_s": None}
    nod = {"name": "nod", "start_s": 1.0, "end_s": 2.0, "uncertainty_s": None}
    table = clips(kept("a", actions=[talk, nod], emotion="happy"))
    texts = written(tables.DESCRIPTIONS, [text("a", "catalogue")])
    (caption,) = captions(texts, table, [written(tables.INTERVALS, [])], album).clips
    assert caption.facts == ["talk at some time", "happy at some time"]
    assert [row.name for row in caption.told[0].rows] == ["nod"]


def test_clips_are_chosen_that_show_something_new(written, album):
    nod = {"name": "nod", "start_s": 0.0, "end_s": 1.0, "uncertainty_s": 0.0}
    table = clips(*(kept(c, actions=[nod] * (c != "e")) for c in "abcd"), kept("e", emotions=[nod]))
    table.at[3, "actions"] = [nod | {"name": "smile"}]
    texts = written(tables.DESCRIPTIONS, [text(c, "catalogue") for c in "abcde"])
    none = written(tables.INTERVALS, [])
    found = captions(texts, table, [none], album)
    assert [caption.clip_id for caption in found.clips][:2] == ["a", "d"]
    assert (found.described, found.texts) == (5, 5)


def test_texts_of_clips_that_were_lost_since_are_not_shown(written, album):
    texts = written(tables.DESCRIPTIONS, [text("gone", "catalogue")])
    found = captions(texts, clips(kept("a")), [written(tables.INTERVALS, [])], album)
    assert found.reason == "no clip is described"


def test_near_duplicates_stand_side_by_side_the_most_alike_first(written, album):
    rows = [("a", "b", "film", 0.7), ("a", "b", "motion", 0.8), ("c", "d", "motion", 0.95)]
    names = ["clip_id", "other_id", "kind", "share"]
    blank = dict.fromkeys(tables.DUPLICATES.schema.names, False)
    path = written(tables.DUPLICATES, [blank | dict(zip(names, row, strict=True)) for row in rows])
    table = clips(*map(kept, "abcd"))
    found = pairs(path, table, {"a": "train", "b": "train", "c": "test"}, album)
    assert (found.total, found.reason) == (2, "")
    assert [(pair.clips, pair.share, pair.place) for pair in found.shown] == [
        (("c", "d"), 0.95, "one is left out"),
        (("a", "b"), 0.8, "both for training"),
    ]
    assert found.shown[1].what == "the film and the motion"
    assert [shot.frame for shot in found.shown[0].shots] == [100, 100]


def test_the_page_shows_a_pair_and_tells_what_it_shares(run):
    arguments = run()
    pair = {"clip_id": "kept_1", "other_id": "twin", "kind": "motion", "share": 0.93}
    blank = dict.fromkeys(tables.DUPLICATES.schema.names, False)
    table = pd.DataFrame([blank | pair], columns=tables.DUPLICATES.schema.names)
    tables.write(tables.DUPLICATES, table, arguments["duplicates"])
    report(**arguments)
    page = arguments["page"].read_text(encoding="utf-8")
    assert "A pair of clips shows the same" in page
    assert "93 % of the motion, one is left out" in page


def test_the_page_says_that_nobody_looked_for_near_duplicates(run):
    arguments = run()
    none = tables.empty(tables.DUPLICATES)
    why = "split.near_duplicates is null"
    tables.write(tables.DUPLICATES, none, arguments["duplicates"], why)
    report(**arguments)
    page = arguments["page"].read_text(encoding="utf-8")
    assert f"near-duplicates were not looked for: {why}" in page


def test_the_page_tells_what_is_shown_and_how_it_reads(plain_page):
    section = plain_page.partition('<section id="shows">')[2].partition("</section>")[0]
    assert "is shown 9.00 times as often" in section
    assert "lighting: soft light" in section
    assert "She smiles, then talks." in section and "The brows go up." in section
    assert "from 0.500 where all that it shows is common to 1.50" in section


def test_with_no_balance_the_page_says_that_clips_weigh_the_same(run):
    arguments = run() | {"balance": 0.0}
    report(**arguments)
    assert "All clips weigh the same" in arguments["page"].read_text(encoding="utf-8")

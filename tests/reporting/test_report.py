import re
from html.parser import HTMLParser

import pandas as pd
import pytest

from mimeline import tables
from mimeline.errors import BadFile
from mimeline.reporting.report import report

HOSTILE = "<script>alert(1)</script>\"'&}}{{ 7 * 7 }}"
VOID = {"meta", "br", "link", "img"}
PLACES = {"href", "src", "xlink:href", "action", "poster", "srcset", "data"}
PICTURES, FILMS = "data:image/webp;base64,", "data:video/mp4;base64,"


class Page(HTMLParser):
    """The tags, ids, addresses and words of a page; refuses tags that are not closed in order."""

    def __init__(self, html: str):
        super().__init__(convert_charrefs=True)
        self.tags, self.ids, self.addresses, self.words = [], [], [], []
        self._open: list[str] = []
        self.feed(html)
        assert not self._open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.ids += [value for name, value in attrs if name == "id"]
        self.addresses += [v for n, v in attrs if n in PLACES]
        self.addresses += [u for n, v in attrs for u in re.findall(r"url\(([^)]*)\)", v or "")]
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag):
        assert self._open.pop() == tag, f"</{tag}> closes another tag"

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def written(arguments: dict) -> tuple[str, Page]:
    report(**arguments)
    html = arguments["page"].read_text(encoding="utf-8")
    return html, Page(html)


def test_the_page_tells_every_stage_cluster_score_and_model_of_a_run(plain_page):
    page = Page(plain_page)
    assert "Of 3 clips, 1 came through" in page.text
    assert "too short 3.4 s 5 s" in page.text
    assert "line 812: found n/a" in page.text
    assert "named by a person" in page.text
    assert "medoid 1.00 s" in page.text and "longest 1.00 s" in page.text
    assert "mimeline label --results" in page.text
    assert "0.910" in page.text
    assert "alignment of the timeline model 0.77" in page.text
    assert "19 steps" in page.text


def test_a_rule_that_was_not_applied_and_a_channel_that_is_absent_or_flat_are_said(plain_page):
    page = Page(plain_page)
    assert "“the head turns too far” was not applied: no head angle is known" in page.text
    assert "1 channel is not measured (browDownLeft)" in page.text
    assert "1 channel hardly moves (browDownRight)" in page.text


def test_channels_that_the_clusters_were_fitted_without_are_said(run, plain_page):
    assert "Fitted without" not in Page(plain_page).text
    arguments = run()
    path, table = arguments["series"]["mouth"], tables.SERIES["mouth", "left"]
    tables.write(table, tables.read(table, path).assign(mouthFrownLeft=0.01), path)
    _, page = written(arguments)
    assert "Fitted without mouthFrownLeft : it hardly moves." in page.text


def test_clusters_without_a_name_and_actions_that_are_not_measured_are_said(run, plain_page):
    arguments = run(unmeasured=("MouthFrown",))
    names = tables.read(tables.LABELS, arguments["labels"])
    mouth, neutral = names["region"] == "mouth", names["action"] == "Neutral"
    names["unmeasured"] = [["MouthFrown"] if own else [] for own in mouth]
    names.loc[mouth & neutral, ["action", "why"]] = [None, "two actions are as likely"]
    tables.write(tables.LABELS, names, arguments["labels"])
    _, page = written(arguments)
    assert "a person named 3, a rule proposed the names of 2 and 1 has no name" in page.text
    assert "1 of the 2 mouth clusters has no name: what 50 % of the frames show" in page.text
    assert "mouth frown: not measured" in page.text
    assert "No channel that moves tells it" in page.text
    assert "two actions are as likely" in page.text
    assert "on a dotted lane mouth frown was not measured" in page.text
    for said in ("no name", "frown: not measured", "dotted lane"):
        assert said not in Page(plain_page).text


def test_frames_of_which_an_action_is_not_known_are_drawn_grey_and_not_as_neutral(run, plain_page):
    arguments = run()
    marked = tables.read(tables.FRAMES, arguments["frames"][0])
    marked.loc[marked["frame"] >= 40, ["BrowUp", "BrowDown"]] = pd.NA
    tables.write(tables.FRAMES, marked, arguments["frames"][0])
    html, page = written(arguments)
    assert 'class="gap"' in html and 'class="gap"' not in plain_page
    assert "not measured, or its cluster has no name: frames 40–59, 0.67 s" in page.text


def test_frames_that_the_timelines_do_not_know_are_told_beside_the_score(run, plain_page):
    assert "60 of" not in Page(plain_page).text
    arguments = run()
    rows = tables.read(tables.METRICS, arguments["annotation_metrics"]).copy()
    rows.loc[(rows["variant"] == "named") & (rows["metric"] == "f1_brow"), "n"] = 45
    tables.write(tables.METRICS, rows, arguments["annotation_metrics"])
    _, page = written(arguments)
    assert "45 of 60" in page.text


def test_a_track_without_its_channels_is_drawn_as_not_measured(run, plain_page):
    head = ("HeadLeft", "HeadRight")
    _, page = written(run(unmeasured=head))
    assert "not measured on the timelines: head, left–right" in page.text
    assert "not measured on the timelines" not in Page(plain_page).text


def test_planted_faults_that_were_not_met_are_counted(plain_page):
    page = Page(plain_page)
    assert "1 of 2 planted faults were met" in page.text
    assert "not seen by pose" in page.text


def test_a_run_of_nothing_gives_a_page_with_its_reasons(empty_run):
    _, page = written(empty_run)
    assert "No clip came through." in page.text
    assert "No clusters: not measured: brow channels." in page.text
    assert "No score: annotation_metrics: no clip came through." in page.text
    assert "No timeline model: there is no window to train on." in page.text
    assert "Nothing to show: intervals: no clip came through." in page.text


def test_ids_notes_and_titles_stay_text(run, video):
    arguments = run(clip=HOSTILE, note=HOSTILE, media={HOSTILE: video})
    arguments["options"] = arguments["options"] | {"title": HOSTILE}
    html, page = written(arguments)
    assert "<script" not in html
    assert "script" not in page.tags
    assert HOSTILE in "".join(page.words)
    assert "49" not in HOSTILE and "}}49" not in html


def test_a_value_that_is_no_number_or_name_of_ours_never_reaches_a_style(run):
    html, _ = written(run(clip='x" style="background: url(http://a)'))
    assert 'style="background: url(' not in html


def test_nothing_on_the_page_comes_from_elsewhere(filmed_page):
    html, page = filmed_page, Page(filmed_page)
    assert page.addresses
    within = {address for address in page.addresses if address.startswith("#")}
    held = set(page.addresses) - within
    assert {address[1:] for address in within} <= set(page.ids)
    assert held and all(re.match(f"({PICTURES}|{FILMS})[A-Za-z0-9+/=]+$", a) for a in held)
    assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags)
    assert "@import" not in html and "@font-face" not in html and "://" not in html


def test_no_id_occurs_twice(filmed_page):
    page = Page(filmed_page)
    assert len(page.ids) == len(set(page.ids))


def test_the_same_tables_give_the_same_page(run):
    arguments = run()
    first, _ = written(arguments)
    second, _ = written(arguments)
    assert first == second


def test_a_page_that_cannot_be_written_leaves_the_old_one(run):
    arguments = run()
    first, _ = written(arguments)
    tables.write(tables.LEDGER, tables.empty(tables.LEDGER), arguments["ledgers"][0])
    with pytest.raises(BadFile):
        report(**arguments)
    assert arguments["page"].read_text(encoding="utf-8") == first


def test_clips_without_a_video_are_no_lack_of_the_run(plain_page):
    head, _, rest = plain_page.partition('<section id="funnel">')
    assert "no video" not in head and "no video was found" in rest

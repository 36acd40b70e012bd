import json
import re
import shutil
from collections import Counter
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.errors import BadConfig, BadFile, NoSuchFile
from mimeline.studio.study import Study
from mimeline.studio.timelines_of_run import KINDS, TimelinesOfRun

from .rated_run import (
    CLIPS,
    FILMED,
    LOST,
    TESTED,
    UNMOVED,
    UNTOLD,
    motion,
    study,
    write_timelines,
)

REAL = ("truth", "annotation", "mismatched")


@pytest.fixture(scope="module")
def usual(rated_once) -> Study:
    return study(rated_once)


def of_kind(found: Study, kind: str) -> list:
    return [pair for pair in found.pairs.values() if pair.kind == kind]


def shown(found: Study, pair) -> dict[str, list]:
    return {track.name: list(track.intervals) for track in found.tracks(pair)}


def test_there_are_as_many_pairs_of_each_kind_as_were_asked_for(usual):
    assert Counter(p.kind for p in usual.pairs.values()) == dict.fromkeys(KINDS, 2)


def test_of_a_kind_there_are_no_more_pairs_than_clips(rated_once):
    counts = Counter(p.kind for p in study(rated_once, pairs=50).pairs.values())
    assert counts == dict.fromkeys(KINDS, len(CLIPS)) | {"generation": len(TESTED)}


def test_clips_of_the_test_part_come_first_and_none_twice_while_there_are_others(usual):
    clips = Counter(p.clip_id for p in usual.pairs.values())
    assert set(TESTED) < set(clips)
    real = [p.clip_id for p in usual.pairs.values() if p.kind != "generation"]
    assert len(set(real)) == len(real)


def test_truth_and_annotation_show_their_own_timelines(usual):
    for kind, shift in (("truth", 2), ("annotation", 0)):
        for pair in of_kind(usual, kind):
            start = CLIPS.index(pair.clip_id) + shift
            frames = {f for _, a, b in shown(usual, pair)["brow"] for f in range(a, b)}
            assert frames == set(range(start, start + 8)) - {LOST}


def test_generated_motion_comes_with_the_timeline_that_was_asked_for(usual):
    for pair in of_kind(usual, "generation"):
        assert pair.clip_id in TESTED and pair.timeline_of == pair.clip_id
        start = CLIPS.index(pair.clip_id)
        assert shown(usual, pair)["brow"][0][:2] == ("BrowUp", start)


def test_a_mismatched_pair_has_the_timeline_of_another_clip(usual):
    for pair in of_kind(usual, "mismatched"):
        assert pair.timeline_of != pair.clip_id
        as_annotated = replace(pair, kind="annotation", timeline_of=pair.clip_id)
        assert shown(usual, pair) != shown(usual, as_annotated)


def test_what_is_not_known_of_the_other_clip_is_no_gap_of_a_mismatched_pair(rated):
    path = rated / "annotate" / "00" / "frames.parquet"
    frames = tables.read(tables.FRAMES, path)
    shutil.rmtree(rated / "toy")  # the truth knows no more
    for n, clip in enumerate(CLIPS):
        frames.loc[(frames["clip_id"] == clip) & (frames["frame"] == 10 + n), "BrowUp"] = pd.NA
    tables.write(tables.FRAMES, frames, path)
    found = study(rated)
    for pair in of_kind(found, "mismatched"):
        own = {LOST, 10 + CLIPS.index(pair.clip_id)}
        brow = next(track for track in found.tracks(pair) if track.name == "brow")
        assert {f for a, b in brow.gaps for f in range(a, b)} == own


def test_no_track_tells_whose_timeline_it_is(usual):
    """What one timeline of a clip does not know is shown of none: gaps, tracks, actions."""
    for pair in usual.pairs.values():
        tracks = {track.name: track for track in usual.tracks(pair)}
        assert [name for name, track in tracks.items() if not track.measured] == ["gaze_v"]
        assert {track.gaps for track in tracks.values() if track.measured} == {((LOST, LOST + 1),)}
        assert tracks["mouth"].absent == (UNTOLD,) and not tracks["mouth"].intervals


def test_everybody_is_shown_the_same_pairs_in_an_order_of_their_own(rated_once, usual):
    again = study(rated_once)
    assert again.pairs == usual.pairs
    ann, bo = ([pair.id for pair in again.order(who)] for who in ("ann", "bo"))
    assert sorted(ann) == sorted(bo) and ann != bo
    assert ann == [pair.id for pair in usual.order("ann")]


def test_another_seed_draws_other_pairs(rated_once, usual):
    other = study(rated_once, seed=1)
    assert not other.pairs.keys() & usual.pairs.keys()
    assert {p.clip_id for p in other.pairs.values()} != {p.clip_id for p in usual.pairs.values()}


def test_ids_tell_nothing(usual):
    kinds = [usual.pairs[name].kind for name in sorted(usual.pairs)]
    assert kinds != sorted(kinds, key=KINDS.index) and kinds != sorted(kinds)
    assert all(re.fullmatch("p[0-9a-f]{11}", name) for name in usual.pairs)


def test_films_are_shown_only_where_nothing_was_generated(rated_once, usual):
    assert not usual.filmed and {p.view for p in usual.pairs.values()} == {"face"}
    filmed = study(rated_once, kinds=REAL)
    assert filmed.filmed and {p.view for p in filmed.pairs.values()} == {"film"}
    assert {p.clip_id for p in filmed.pairs.values()} <= set(FILMED)
    assert not filmed.pairs.keys() & usual.pairs.keys()


def test_where_films_are_too_few_all_are_drawn(rated_once):
    drawn = study(rated_once, pairs=len(FILMED) + 1, kinds=REAL)
    assert {p.view for p in drawn.pairs.values()} == {"face"}


def test_real_and_generated_motion_are_drawn_alike(usual):
    for name in usual.pairs:
        motion = usual.motion[name]
        assert motion[UNMOVED].isna().all()
        assert motion.loc[~motion["valid"], "frame"].tolist() == [LOST]


def test_generated_motion_is_what_the_model_made(usual, rated_once):
    path = rated_once / "evaluate" / "timeline" / "generated.parquet"
    made = tables.read(tables.MOTION, path).set_index("clip_id")
    for pair in of_kind(usual, "generation"):
        own = made.loc[pair.clip_id, "jawOpen"].to_numpy()
        np.testing.assert_array_equal(usual.motion[pair.id]["jawOpen"], own)


def test_a_kind_that_the_run_has_not_is_left_out_and_said(rated):
    shutil.rmtree(rated / "evaluate")
    shutil.rmtree(rated / "toy")
    run = TimelinesOfRun(rated)
    assert Study(run, 2, 0).kinds == ("annotation", "mismatched")
    assert "evaluate_timeline" in run.absent["generation"]
    assert "evaluate.truth" in run.absent["truth"]
    with pytest.raises(BadConfig, match="--kinds.*generation.*evaluate_timeline"):
        Study(run, 2, 0, ["generation"])


def test_truth_is_read_from_where_the_run_was_told(rated, tmp_path):
    elsewhere = (rated / "toy" / "truth").rename(tmp_path / "truth")
    told = {"config": {"evaluate": {"truth": str(elsewhere)}}, "files": [], "given": []}
    (rated / "run.json").write_text(json.dumps(told))
    assert "truth" in study(rated).kinds
    shutil.rmtree(elsewhere)
    run = TimelinesOfRun(rated)
    assert "truth" not in run.of_kind and str(elsewhere) in run.absent["truth"]


def test_another_run_has_another_fingerprint_and_other_ids(rated, usual):
    assert study(rated).results == usual.results  # a copy is the same
    write_timelines(rated, shift=1)
    assert study(rated).results != usual.results
    assert not study(rated).pairs.keys() & usual.pairs.keys()


@pytest.mark.parametrize("what", ["motion", "film", "face"])
def test_what_is_seen_is_of_the_fingerprint_as_well(rated, usual, what, tmp_path):
    if what == "motion":
        path = rated / "ingest" / "00" / "motion.parquet"
        tables.write(tables.MOTION, motion(CLIPS, 7.0), path)
    elif what == "film":
        with open(rated / "fetch" / "00" / "media" / f"{FILMED[0]}.mp4", "ab") as film:
            film.write(b"more")
    else:
        face = tmp_path / "face.glb"
        face.write_bytes(b"another face")
        told = {"config": {"report": {"face": str(face)}}, "files": [], "given": []}
        (rated / "run.json").write_text(json.dumps(told))
    assert TimelinesOfRun(rated).fingerprint() != usual.results


@pytest.mark.parametrize("what", ["timelines", "motion"])
def test_results_that_change_meanwhile_are_told(rated, what):
    run = TimelinesOfRun(rated)
    run.refuse_changed()
    if what == "timelines":
        write_timelines(rated, shift=1)
    else:
        tables.write(tables.MOTION, motion(CLIPS, 7.0), rated / "ingest" / "00" / "motion.parquet")
    with pytest.raises(BadFile, match="the run went on"):
        run.refuse_changed()


def test_no_pair_is_a_plain_error(rated_once):
    with pytest.raises(BadConfig, match="--pairs: found 0"):
        study(rated_once, pairs=0)


def test_a_kind_that_is_none_is_a_plain_error(rated_once):
    with pytest.raises(BadConfig, match="--kinds: found nonsense, expected some of truth"):
        study(rated_once, kinds=["nonsense"])


def test_a_folder_without_results_or_timelines_is_a_plain_error(rated, tmp_path):
    with pytest.raises(NoSuchFile, match="no results of a run.*--results"):
        TimelinesOfRun(tmp_path / "nothing")
    shutil.rmtree(rated / "annotate")
    with pytest.raises(NoSuchFile, match="no timelines.*--until annotate"):
        TimelinesOfRun(rated)


def test_a_run_without_a_clip_is_a_plain_error(rated):
    path = rated / "annotate" / "00" / "frames.parquet"
    tables.write(tables.FRAMES, tables.empty(tables.FRAMES), path, "no clip came through")
    with pytest.raises(NoSuchFile, match="no clip with a timeline"):
        TimelinesOfRun(rated)


def test_timelines_of_which_nothing_is_known_are_a_plain_error(rated):
    path = rated / "annotate" / "00" / "frames.parquet"
    frames = tables.read(tables.FRAMES, path)
    frames.iloc[:, 2:] = None
    tables.write(tables.FRAMES, frames, path)
    with pytest.raises(NoSuchFile, match="no track that is known"):
        study(rated)

import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.label_file import Answer, RegionAnswers
from mimeline.annotation.moving import move
from mimeline.annotation.runs import cluster_runs

UP, DOWN, REST = Answer("BrowUp"), Answer("BrowDown"), Answer("Neutral")

NOTHING_KNOWN = (
    "none of its frames was known before: another frame rate, other clips, or a lost fit"
)


def fit(*clusters: int, run=20, repeat=5, clips="abcd") -> pd.DataFrame:
    """A `clusters` table: in each clip, runs of these clusters, over and over."""
    cluster = np.repeat(np.tile(clusters, repeat), run)
    parts = [
        pd.DataFrame({"clip_id": clip, "frame": range(len(cluster)), "cluster": cluster})
        for clip in clips
    ]
    return pd.concat(parts, ignore_index=True).assign(margin=1.0)


def moved(answers, before, after, min_agreement=0.8, shown=None, n_names=2):
    given = RegionAnswers("f", answers, shown or {})
    segments = None if before is None else cluster_runs(before)
    return move(given, segments, after, n_names, min_agreement)


def test_clusters_in_another_order_take_their_names_along():
    found = moved({0: UP, 1: DOWN, 2: REST}, fit(0, 1, 2), fit(2, 0, 1))
    assert found.answers == {2: UP, 0: DOWN, 1: REST}
    assert (found.unsafe, found.kept, found.known) == ({}, 1, 1)
    assert set(found.shares.values()) == {1.0}


def test_the_parts_of_a_cluster_that_is_split_have_its_name():
    found = moved({0: UP, 1: REST}, fit(0, 0, 1), fit(0, 2, 1))
    assert found.answers == {0: UP, 2: UP, 1: REST}


def test_a_cluster_that_merges_two_names_is_not_safe():
    names = {0: UP, 1: DOWN} | dict.fromkeys(range(2, 12), REST)
    found = moved(names, fit(*range(12)), fit(0, 0, *range(2, 12)))
    assert set(found.unsafe) == {0}
    assert "BrowUp 50%" in found.unsafe[0]
    assert "BrowDown 50%" in found.unsafe[0]
    assert 0 not in found.answers
    assert found.kept == pytest.approx(10 / 12)


def test_a_cluster_that_merges_two_of_one_name_has_it():
    found = moved({0: UP, 1: UP, 2: REST}, fit(0, 1, 2), fit(0, 0, 1))
    assert found.answers == {0: UP, 1: REST}


@pytest.mark.parametrize(("agreement", "safe"), [(0.79, True), (0.81, False)])
def test_as_much_of_a_cluster_must_have_borne_the_name_as_is_asked_for(agreement, safe):
    names = dict.fromkeys(range(4), UP) | dict.fromkeys(range(4, 10), REST)
    found = moved(names, fit(*range(10)), fit(0, 0, 0, 0, 0, 5, 5, 5, 5, 5), agreement)
    assert (0 in found.answers) == safe
    if safe:
        assert found.shares[0] == pytest.approx(0.8)


def test_a_note_moves_where_the_frames_bore_it_too():
    strong, weak = Answer("BrowUp", "strong"), Answer("BrowUp", "weak")
    found = moved({0: strong, 1: weak, 2: strong}, fit(0, 1, 2), fit(0, 0, 1))
    assert found.answers == {0: Answer("BrowUp"), 1: strong}
    assert found.kept == 1


def test_not_sure_stays_not_sure():
    found = moved({0: Answer(), 1: REST}, fit(0, 1), fit(1, 0))
    assert found.answers == {1: Answer(), 0: REST}


def test_what_nobody_named_keeps_the_proposal_of_its_new_cluster():
    found = moved({0: UP}, fit(0, 1), fit(1, 0))
    assert found.answers == {1: UP}
    assert found.unsafe == {}
    assert found.kept == 1


def test_a_mixture_of_what_was_named_and_what_was_not_is_not_safe():
    found = moved({0: UP}, fit(*range(12)), fit(0, 0, *range(2, 12)))
    assert set(found.unsafe) == {0}
    assert "BrowUp 50%" in found.unsafe[0]
    assert "no name 50%" in found.unsafe[0]


def test_merged_clusters_move_with_the_name_of_the_one_they_are_the_same_as():
    answers = {0: UP, 1: Answer(same_as=0), 2: Answer(same_as=1), 3: REST}
    found = moved(answers, fit(0, 1, 2, 3), fit(0, 1, 1, 2))
    assert found.answers == {0: UP, 1: UP, 2: REST}


def test_what_lost_its_name_in_a_refit_has_none_to_give_in_the_next():
    given = RegionAnswers("f", {1: REST, 2: DOWN}, open=frozenset({0}))
    found = move(given, cluster_runs(fit(0, 1, 1, 1, 2, 2)), fit(3, 1, 1, 1, 2, 2), 2, 0.8)
    assert set(found.unsafe) == {3}
    assert found.answers == {1: REST, 2: DOWN}


def test_a_cluster_merged_into_one_that_nobody_named_is_not_safe():
    answers = {0: Answer(same_as=1)} | dict.fromkeys(range(2, 12), REST)
    found = moved(answers, fit(*range(12)), fit(*range(12)))
    assert found.unsafe == {0: "its frames bore that of an unnamed cluster 100%"}


def test_clips_that_are_new_do_not_hinder_and_clips_that_are_gone_do_not_count():
    found = moved({0: UP, 1: REST}, fit(0, 1, clips="abc"), fit(1, 0, clips="bcd"))
    assert found.answers == {1: UP, 0: REST}
    assert found.known == pytest.approx(2 / 3)


def test_a_cluster_that_only_new_clips_show_is_not_safe():
    after = pd.concat([fit(0, 1, clips="ab"), fit(2, 1, clips="xy")], ignore_index=True)
    found = moved({0: UP, 1: REST}, fit(0, 1, clips="ab"), after)
    assert found.answers == {0: UP, 1: REST}
    assert found.unsafe == {2: NOTHING_KNOWN}


def test_a_cluster_of_which_little_was_known_is_not_safe():
    after = fit(0, 1, clips="abcdefghijklmnopqrstuvwxyz")
    found = moved({0: UP, 1: REST}, fit(0, 1, clips="a"), after)
    assert set(found.unsafe) == {0, 1}
    assert "only 100 of its 2600 frames were known before" in found.unsafe[0]


def test_a_data_set_ten_times_as_large_has_the_names_of_its_tenth():
    found = moved({0: UP, 1: REST}, fit(0, 1, clips="a"), fit(1, 0, clips="abcdefghij"))
    assert found.answers == {1: UP, 0: REST}
    assert found.known == pytest.approx(0.1)


@pytest.mark.parametrize("change", [{"run": 24}, {"clips": "wxyz"}])
def test_another_frame_rate_and_other_clips_make_nothing_known(change):
    found = moved({0: UP, 1: REST}, fit(0, 1), fit(0, 1, **change))
    assert found.known == 0
    assert found.answers == {}
    assert set(found.unsafe.values()) == {NOTHING_KNOWN}


def test_between_fits_that_have_little_in_common_nothing_is_moved():
    names = {0: UP, 1: DOWN, 2: REST}
    found = moved(names, fit(0, 1, 2), fit(0, 1, 1))
    assert set(found.unsafe) == {0, 1}
    assert "as the fits differ" in found.unsafe[0]
    assert (found.answers, found.kept) == ({}, 0)


def test_clusters_too_few_to_tell_all_names_apart_give_theirs_to_no_part():
    found = moved({0: UP, 1: REST}, fit(0, 0, 1), fit(0, 2, 1), n_names=3)
    assert set(found.unsafe) == {0, 1, 2}
    assert "2 cluster(s) were known before, too few to tell 3 names apart" in found.unsafe[0]
    assert moved({0: UP, 1: REST}, fit(0, 1), fit(1, 0), n_names=3).answers == {1: UP, 0: REST}


def seen(*rows):
    return tuple((clip, start, end) for clip, start, end in rows)


def test_without_the_old_fit_names_move_by_the_intervals_that_the_person_saw():
    shown = {0: seen(("a", 0, 20), ("b", 40, 60), ("c", 80, 100)),
             1: seen(("a", 20, 40), ("b", 60, 80), ("c", 100, 120))}  # fmt: skip
    found = moved({0: UP, 1: REST}, None, fit(3, 4), shown=shown)
    assert found.answers == {3: UP, 4: REST}
    assert found.known == pytest.approx(120 / 800)


def test_two_intervals_are_too_few_to_know_a_cluster_by():
    shown = {0: seen(("a", 0, 20), ("b", 40, 60), ("c", 80, 100)), 1: seen(("a", 20, 40))}
    found = moved({0: UP, 1: REST}, None, fit(3, 4), shown=shown)
    assert set(found.unsafe) == {4}


def test_intervals_beyond_the_end_of_a_clip_show_that_its_frames_are_others():
    shown = {0: seen(("a", 0, 20), ("b", 40, 60), ("c", 80, 100), ("d", 900, 920))}
    assert moved({0: UP}, None, fit(3, 4), shown=shown).known == 0


def test_a_clip_whose_last_frame_is_masked_now_is_still_the_same():
    shown = {0: seen(("a", 0, 20), ("b", 40, 60), ("c", 80, 100), ("d", 160, 201)),
             1: seen(("a", 20, 40), ("b", 60, 80), ("c", 100, 120))}  # fmt: skip
    assert moved({0: UP, 1: REST}, None, fit(3, 4), shown=shown).known == pytest.approx(160 / 800)


def test_without_the_old_fit_and_without_intervals_nothing_moves():
    found = moved({0: UP}, None, fit(0, 1))
    assert set(found.unsafe) == {0, 1}
    assert (found.kept, found.known) == (0, 0)

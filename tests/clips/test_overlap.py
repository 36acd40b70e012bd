import numpy as np
import pandas as pd
import pytest

from mimeline.clips.overlap import duplicates

EDGES = ("bbox_top", "bbox_bottom", "bbox_left", "bbox_right")


def clips(*rows: dict) -> pd.DataFrame:
    """Rows of one source, from 0 to 6 s, without a box, unless they say otherwise."""
    blank = {"source_id": "s", "subject_id": None, "video": None, "start_s": 0.0, "end_s": 6.0}
    blank |= dict.fromkeys(EDGES, np.nan)
    boxes = [dict(zip(EDGES, row.pop("box"), strict=True)) if "box" in row else {} for row in rows]
    return pd.DataFrame([blank | row | box for row, box in zip(rows, boxes, strict=True)])


def gone(table: pd.DataFrame, max_overlap: float = 0.5) -> dict[str, str]:
    found = duplicates(table, max_overlap)
    return dict(zip(found["clip_id"], found["stays"], strict=True))


def test_a_record_that_occurs_twice_goes_once():
    assert gone(clips({"clip_id": "b"}, {"clip_id": "a"})) == {"b": "a"}


def test_the_first_in_time_stays_whatever_the_order_of_the_file():
    rows = [
        {"clip_id": "z", "start_s": 1.0, "end_s": 7.0},
        {"clip_id": "y", "start_s": 2.0, "end_s": 8.0},
        {"clip_id": "x", "start_s": 6.0, "end_s": 12.0},
    ]
    assert gone(clips(*rows)) == gone(clips(*rows[::-1])) == {"y": "z"}


def test_a_clip_that_lies_in_a_longer_one_is_a_duplicate():
    table = clips(
        {"clip_id": "long", "end_s": 20.0}, {"clip_id": "part", "start_s": 9, "end_s": 12}
    )
    assert gone(table) == {"part": "long"}


def test_a_clip_like_one_that_went_itself_stays():
    rows = [{"clip_id": n, "start_s": s, "end_s": s + 9} for n, s in (("a", 0), ("b", 4), ("c", 8))]
    assert gone(clips(*rows)) == {"b": "a"}


def test_two_faces_side_by_side_are_no_duplicates():
    left, right = (0.1, 0.9, 0.0, 0.5), (0.1, 0.9, 0.45, 1.0)
    assert gone(clips({"clip_id": "a", "box": left}, {"clip_id": "b", "box": right})) == {}
    assert gone(clips({"clip_id": "a", "box": left}, {"clip_id": "b", "box": left})) == {"b": "a"}


def test_a_clip_without_a_box_shows_the_whole_picture():
    box = (0.1, 0.9, 0.0, 0.5)
    half_known = (0.1, 0.9, 0.0, np.nan)
    for other in ({}, {"box": half_known}):
        table = clips({"clip_id": "a", **other}, {"clip_id": "b", "box": box})
        assert gone(table) == {"b": "a"}


@pytest.mark.parametrize(
    ("facts", "expected"),
    [
        (("anna", "bert"), {}),
        (("anna", "anna"), {"b": "a"}),
        (("anna", None), {"b": "a"}),
        ((None, None), {"b": "a"}),
    ],
)
def test_two_people_are_no_duplicates_and_somebody_unknown_may_be_one(facts, expected):
    table = clips(*({"clip_id": n, "subject_id": f} for n, f in zip("ab", facts, strict=True)))
    assert gone(table) == expected


def test_other_sources_and_other_videos_of_a_source_are_no_duplicates():
    rows = [
        {"clip_id": "a"},
        {"clip_id": "b", "source_id": "t"},
        {"clip_id": "c", "video": "c.mp4"},
    ]
    assert gone(clips(*rows)) == {}


def test_takes_that_were_cut_one_after_the_other_share_nothing():
    starts = 0.1 + np.arange(3000) * 0.7
    rows = [{"clip_id": f"t_{n:04d}", "start_s": s, "end_s": s + 0.7} for n, s in enumerate(starts)]
    assert gone(clips(*rows), max_overlap=0.0) == {}


def test_the_share_is_that_of_the_clip_it_overlaps_most():
    rows = [
        {"clip_id": "a", "end_s": 10.0},
        {"clip_id": "b", "start_s": 6.0, "end_s": 16.0},
        {"clip_id": "c", "start_s": 7.0, "end_s": 17.0},
    ]
    (found,) = duplicates(clips(*rows), 0.5).itertuples(index=False)
    assert (found.clip_id, found.stays) == ("c", "b")
    assert found.share == pytest.approx(0.9)


def pairwise(table: pd.DataFrame, max_overlap: float) -> dict[str, str]:
    """The definition, word by word: every clip against every one that stays before it."""
    stay, found = [], {}
    for clip in sorted(table.itertuples(), key=lambda c: (c.start_s, c.clip_id)):
        shares = {}
        for other in stay:
            if clip.source_id != other.source_id:
                continue
            if len({clip.subject_id, other.subject_id} - {"nobody"}) == 2:
                continue
            shared = min(clip.end_s, other.end_s) - max(clip.start_s, other.start_s)
            shorter = min(clip.end_s - clip.start_s, other.end_s - other.start_s)
            shares[other.clip_id] = min(shared / shorter, covered(clip, other))
        most = max(shares, key=shares.get, default=None)
        if most and shares[most] > max_overlap:
            found[clip.clip_id] = most
        else:
            stay.append(clip)
    return found


def covered(one, other) -> float:
    a, b = ([getattr(clip, edge) for edge in EDGES] for clip in (one, other))
    if np.isnan([a, b]).any():
        return 1.0
    high, wide = (min(a[k + 1], b[k + 1]) - max(a[k], b[k]) for k in (0, 2))
    smaller = min((box[1] - box[0]) * (box[3] - box[2]) for box in (a, b))
    return max(high, 0) * max(wide, 0) / smaller


@pytest.mark.parametrize("seed", range(8))
def test_the_sweep_finds_what_looking_at_every_pair_finds(seed):
    rng = np.random.default_rng(seed)
    n = 120
    top, left = rng.uniform(0, 0.4, (2, n))
    high, wide = rng.uniform(0.3, 0.6, (2, n))
    start = np.round(rng.uniform(0, 60, n), 1)
    table = pd.DataFrame(
        {
            "clip_id": rng.permutation([f"c{k}" for k in range(n)]),
            "source_id": rng.choice(["s", "t"], n),
            "subject_id": rng.choice(["p", "q", "nobody"], n),
            "video": None,
            "start_s": start,
            "end_s": start + np.round(rng.gamma(2, 4, n) + 0.1, 1),
            "bbox_top": np.where(rng.random(n) < 0.2, np.nan, top),
            "bbox_bottom": top + high,
            "bbox_left": left,
            "bbox_right": left + wide,
        }
    )
    max_overlap = rng.uniform(0.1, 0.9)
    expected = pairwise(table, max_overlap)
    assert expected
    assert gone(table.replace({"subject_id": {"nobody": None}}), max_overlap) == expected

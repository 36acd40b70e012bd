import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.dataset.split import PARTS, by_group, by_time, groups, leaks, split

SHARES = {"val": 0.05, "test": 0.05}


def clips_of(rows, length_s=10.0) -> pd.DataFrame:
    """The `clips` table of (source, person) pairs; a source's clips follow each other in time."""
    table = pd.DataFrame(rows, columns=["source_id", "subject_id"], dtype="str")
    start = table.groupby("source_id").cumcount() * length_s
    table = table.reindex(columns=tables.CLIPS.schema.names).assign(
        clip_id=pd.Series([f"clip_{number:03}" for number in range(len(table))], dtype="str"),
        start_s=start.astype(float),
        end_s=start + length_s,
        shard=0,
    )
    for name in ("actions", "emotions", "attributes", "texts"):
        table[name] = pd.Series([[]] * len(table), dtype=object)
    return table.assign(fps_num=30, fps_den=1)


def pairs_of(*ends) -> pd.DataFrame:
    """Near-duplicates of clips by number."""
    rows = [(f"clip_{a:03}", f"clip_{b:03}", "film", 0.8, False) for a, b in ends]
    return pd.DataFrame(rows, columns=["clip_id", "other_id", "kind", "share", "mirrored"])


def parts_of(clips, shares=SHARES, seed=0, pairs=None) -> pd.Series:
    """The part of each clip, by group."""
    grouped = clips.assign(group=groups(clips, pairs))
    return pd.Series(by_group(grouped, shares, np.random.default_rng(seed)), index=clips.index)


def sides(parts, key):
    """The largest number of parts that clips of one source or one person lie on."""
    return parts.groupby(key).nunique().max()


def test_clips_are_tied_by_source_and_by_person_and_by_chains_of_them():
    clips = clips_of(
        [("1", "A"), ("2", "A"), ("2", "B"), ("3", "B"), ("4", None), ("4", "C"), ("5", None)]
    )
    found = groups(clips)
    assert len(set(found[:4])) == 1
    assert len(set(found[4:6])) == 1
    assert len(set(found)) == 3


def test_a_source_and_a_person_of_one_name_are_not_the_same():
    found = groups(clips_of([("x", "y"), ("y", "z"), ("z", None)]))
    assert len(set(found)) == 3


def test_groups_do_not_depend_on_the_order_of_clips():
    clips = clips_of([("1", "A"), ("2", "B"), ("3", "C"), ("1", "C"), ("2", "A"), ("4", None)])
    backwards = clips.iloc[::-1]
    assert groups(backwards)[::-1] == groups(clips)


def test_near_duplicates_tie_all_clips_of_their_sources():
    clips = clips_of([("1", None), ("1", None), ("2", None), ("3", "C"), ("4", "C"), ("5", None)])
    found = groups(clips, pairs_of((1, 2), (4, 2)))
    assert len(set(found[:5])) == 1
    assert len(set(found)) == 2


@settings(max_examples=50, deadline=None)
@given(
    ends=st.lists(st.tuples(st.integers(0, 19), st.integers(0, 19)), max_size=20),
    order=st.randoms(use_true_random=False),
)
def test_groups_do_not_depend_on_the_order_of_pairs(ends, order):
    clips = clips_of([(str(n // 2), "P" if n % 5 == 0 else None) for n in range(20)])
    shuffled = [end[:: order.choice((1, -1))] for end in order.sample(ends, len(ends))]
    assert groups(clips, pairs_of(*ends)) == groups(clips, pairs_of(*shuffled))


IDS = st.sampled_from("12345678")
PEOPLE = st.one_of(st.none(), st.sampled_from("ABCDEFGH"))


@settings(max_examples=150, deadline=None)
@given(
    rows=st.lists(st.tuples(IDS, PEOPLE), min_size=1, max_size=30),
    shares=st.fixed_dictionaries(
        {"val": st.sampled_from([0.0, 0.05, 0.3]), "test": st.sampled_from([0.0, 0.05, 0.6])}
    ),
    seed=st.integers(0, 9),
    ends=st.lists(st.tuples(st.integers(0, 29), st.integers(0, 29)), max_size=6),
)
def test_no_source_no_person_and_no_near_duplicate_lies_on_two_sides(rows, shares, seed, ends):
    clips = clips_of(rows)
    pairs = pairs_of(*(pair for pair in ends if max(pair) < len(rows)))
    parts = parts_of(clips, shares, seed, pairs)
    assert sides(parts, clips["source_id"]) == 1
    if clips["subject_id"].notna().any():
        assert sides(parts, clips["subject_id"]) == 1
    part_of = parts.set_axis(clips["clip_id"])
    assert (part_of[pairs["clip_id"]].to_numpy() == part_of[pairs["other_id"]].to_numpy()).all()
    if len(set(groups(clips, pairs))) >= len(PARTS):
        assert set(parts) == {"train", *(part for part, share in shares.items() if share > 0)}


def test_each_part_gets_a_group_even_if_all_but_one_are_large():
    rows = [("1", None)] * 10 + [("2", None)] * 10 + [("3", None)]
    for seed in range(6):
        parts = parts_of(clips_of(rows), seed=seed)
        assert set(parts) == set(PARTS)
        assert (parts == "val").sum() == 1


def test_the_largest_group_of_three_goes_to_training():
    rows = [("1", None)] * 30 + [("2", None)] * 2 + [("3", None)] * 3
    for seed in range(6):
        assert (parts_of(clips_of(rows), seed=seed) == "train").sum() == 30


def test_training_keeps_a_group_even_if_the_shares_leave_it_little():
    rows = [("1", None), ("2", None), ("3", None)]
    assert set(parts_of(clips_of(rows), {"val": 0.59, "test": 0.4})) == set(PARTS)


def test_sizes_are_near_the_shares_with_many_groups():
    rng = np.random.default_rng(0)
    rows = [(str(n), None) for n in range(400) for _ in range(rng.integers(1, 6))]
    for seed in range(4):
        sizes = parts_of(clips_of(rows), seed=seed).value_counts(normalize=True)
        assert sizes["val"] == pytest.approx(0.05, abs=0.005)
        assert sizes["test"] == pytest.approx(0.05, abs=0.005)


def test_a_group_that_a_part_hardly_wants_stays_in_training():
    rows = [("large", None)] * 20 + [(str(n), None) for n in range(80)]
    for seed in range(60):
        sizes = parts_of(clips_of(rows), seed=seed).value_counts()
        assert sizes[["val", "test"]].tolist() == [5, 5]


def test_the_seed_and_not_the_order_of_clips_decides():
    clips = clips_of([(str(n % 20), None) for n in range(60)])
    parts = parts_of(clips, seed=1)
    shuffled = clips.sample(frac=1, random_state=0)
    assert parts.equals(parts_of(shuffled, seed=1).sort_index())
    assert not parts.equals(parts_of(clips, seed=2))


def test_blocks_of_time_go_from_training_over_validation_to_testing_with_gaps():
    clips = clips_of([("1", None)] * 20)
    parts = by_time(clips, {"val": 0.1, "test": 0.1}, gap_s=1.0)
    expected = ["train"] * 14 + [""] + ["val"] * 2 + [""] + ["test"] * 2
    assert parts.tolist() == expected


def test_a_longer_gap_leaves_out_more_and_none_leaves_out_nothing():
    clips = clips_of([("1", None)] * 20)
    left_out = [(by_time(clips, SHARES, gap_s=gap) == "").sum() for gap in (0.0, 10.0, 10.5, 25.0)]
    assert left_out == [0, 2, 4, 6]


def test_a_clip_that_reaches_over_later_ones_is_left_out_too():
    clips = clips_of([("1", None)] * 10)
    clips.loc[2, "end_s"] = 95.0
    parts = by_time(clips, {"val": 0.0, "test": 0.1}, gap_s=1.0)
    assert parts.tolist() == ["train"] * 2 + [""] + ["train"] * 5 + ["", "test"]


@settings(max_examples=100, deadline=None)
@given(
    rows=st.lists(
        st.tuples(st.sampled_from("12"), st.integers(0, 100), st.integers(1, 30)), max_size=15
    ),
    gap_s=st.integers(0, 20),
)
def test_parts_of_a_source_lie_the_gap_apart(rows, gap_s):
    clips = clips_of([(source, None) for source, _, _ in rows])
    clips["start_s"] = [float(start) for _, start, _ in rows]
    clips["end_s"] = [float(start + length) for _, start, length in rows]
    parts = by_time(clips, {"val": 0.2, "test": 0.1}, gap_s)
    clips = clips.assign(order=[PARTS.index(part) if part else -1 for part in parts])
    clips = clips[clips["order"] >= 0]
    pairs = clips.merge(clips, on="source_id", suffixes=("", "_later"))
    pairs = pairs[pairs["order"] < pairs["order_later"]]
    assert (pairs["start_s_later"] - pairs["end_s"] >= gap_s).all()
    assert not rows or (clips["order"] == 0).any()


@settings(max_examples=100, deadline=None)
@given(
    sources=st.lists(st.sampled_from("12"), min_size=1, max_size=15),
    ends=st.lists(st.tuples(st.integers(0, 14), st.integers(0, 14)), max_size=8),
)
def test_blocks_of_time_leave_out_near_duplicates_but_not_all_of_training(sources, ends):
    clips = clips_of([(source, None) for source in sources])
    pairs = [(a, b) for a, b in ends if max(a, b) < len(sources) and sources[a] != sources[b]]
    parts = by_time(clips, {"val": 0.2, "test": 0.2}, gap_s=1.0)
    left_out = leaks(clips["clip_id"], parts, pairs_of(*pairs))
    part_of = dict(zip(clips["clip_id"], parts, strict=True))
    kept = {clip: part for clip, part in part_of.items() if part and clip not in left_out}
    for one, other in zip(*pairs_of(*pairs)[["clip_id", "other_id"]].to_numpy().T, strict=True):
        assert kept.get(one, "") == "" or kept.get(other, kept[one]) == kept[one]
    assert "train" in kept.values()
    assert all(part_of[clip] != part_of[other] for clip, other in left_out.items())


def test_between_two_sources_no_gap_is_needed():
    clips = clips_of([("1", None)] * 8 + [("2", None)] * 2)
    parts = by_time(clips, {"val": 0.0, "test": 0.2}, gap_s=5.0)
    assert parts.tolist() == ["train"] * 8 + ["test"] * 2


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
@pytest.mark.parametrize("gap_s", [1.0, 1000.0])
def test_few_clips_of_one_source_leave_something_for_training(count, gap_s):
    parts = by_time(clips_of([("1", None)] * count), SHARES, gap_s)
    assert len(parts) == count
    assert "train" in parts or count == 0
    assert ("test" in parts) == (count >= 3 and gap_s < 20)


@pytest.fixture
def run(tmp_path):
    def run(clips, gap_s=1.0, seed=0, shards=2, pictures=(), near_duplicates=0.5):
        """pictures: of clip numbers, the bits of the pictures of each second."""
        clips = clips.assign(shard=np.arange(len(clips)) % shards)
        films = pd.DataFrame(
            [(f"clip_{n:03}", 30 * k, bit) for n, bits in pictures for k, bit in enumerate(bits)],
            columns=["clip_id", "frame", "bits"],
        )
        paths = []
        for shard in range(shards):
            rows = clips[clips["shard"] == shard]
            value = rows["clip_id"].str[-3:].astype(int) / 1000
            motion = pd.DataFrame({"clip_id": rows["clip_id"], "frame": 0, "jawOpen": value})
            motion = motion.reindex(columns=tables.MOTION.schema.names).assign(valid=True)
            paths.append([tmp_path / f"{name}{shard}.parquet" for name in "cmf"])
            tables.write(tables.CLIPS, rows, paths[-1][0])
            tables.write(tables.MOTION, motion, paths[-1][1])
            own = films[films["clip_id"].isin(rows["clip_id"])]
            tables.write(tables.FINGERPRINTS, own, paths[-1][2])
        out = [
            tmp_path / f"{name}.parquet" for name in ("split", "duplicates", "statistics", "ledger")
        ]
        options = {"gap_s": gap_s, "near_duplicates": near_duplicates, "seed": seed}
        split(*zip(*paths, strict=True), *out, val=0.1, test=0.1, **options)
        return [
            tables.read(table, path)
            for table, path in zip(
                (tables.SPLIT, tables.STATISTICS, tables.LEDGER),
                (out[0], out[2], out[3]),
                strict=True,
            )
        ]

    return run


def words(seed: int, n: int = 6) -> list[int]:
    return np.random.default_rng(seed).integers(-(2**63), 2**63 - 1, n).tolist()


def test_near_duplicates_are_in_one_part_in_the_ledger_and_in_their_table(run, tmp_path):
    clips = clips_of([(str(n), None) for n in range(40)])
    pictures = [(n, words(n)) for n in range(20)] + [(n + 20, words(n)) for n in range(3)]
    parts, _, ledger = run(clips, pictures=pictures)
    group = parts.set_index("clip_id")["group"]
    for n in range(3):
        assert group[f"clip_{n:03}"] == group[f"clip_{n + 20:03}"]
    noted = ledger[ledger["rule"] == "near_duplicate"].set_index("clip_id")
    assert len(noted) == 6
    assert (
        noted.loc["clip_020", "detail"]
        == "100% of the pictures of the shorter are those of clip_000"
    )
    found = tables.read(tables.DUPLICATES, tmp_path / "duplicates.parquet")
    assert found["clip_id"].tolist() == ["clip_000", "clip_001", "clip_002"]
    assert found["other_id"].tolist() == ["clip_020", "clip_021", "clip_022"]
    parts, _, ledger = run(clips, pictures=pictures, near_duplicates=None)
    assert parts["group"].nunique() == 40
    assert ledger["rule"].isna().all()
    assert "null" in tables.reason(tmp_path / "duplicates.parquet")


def test_a_near_duplicate_of_a_later_block_of_time_is_left_out(run):
    clips = clips_of([("1", None)] * 19 + [("2", None)])
    parts, _, ledger = run(clips, pictures=[(5, words(0)), (19, words(0))])
    dropped = ledger[ledger["rule"] == "near_duplicate"].query("status == 'dropped'")
    assert dropped["clip_id"].tolist() == ["clip_005"]
    assert dropped["detail"].tolist() == ["clip_019 is in another part"]
    assert parts.set_index("clip_id")["part"]["clip_019"] == "test"


def test_two_uploads_of_one_persons_video_lie_in_one_block_of_time(run):
    clips = clips_of([("1", "A")] * 10 + [("2", "A")] * 10)
    parts, _, ledger = run(clips, pictures=[(5, words(0)), (19, words(0))])
    dropped = ledger[ledger["rule"] == "near_duplicate"].query("status == 'dropped'")
    assert dropped["clip_id"].tolist() == ["clip_005"]
    assert parts.set_index("clip_id")["part"]["clip_019"] == "test"


def test_every_clip_is_in_one_part_and_in_the_ledger(run):
    clips = clips_of([(str(n // 2), None) for n in range(40)])
    parts, _, ledger = run(clips)
    assert parts["clip_id"].tolist() == clips["clip_id"].tolist()
    assert ledger["clip_id"].tolist() == clips["clip_id"].tolist()
    assert set(ledger["status"]) == {"kept"}
    assert parts["part"].value_counts().to_dict() == {"train": 32, "val": 4, "test": 4}


def test_a_split_by_time_is_noted_and_what_lies_between_is_dropped(run):
    clips = clips_of([("1", "A")] * 20)
    parts, _, ledger = run(clips)
    assert len(ledger) == 20
    dropped = ledger[ledger["status"] == "dropped"]
    assert set(dropped["rule"]) == {"split_gap"}
    assert dropped["limit"].tolist() == [1.0, 1.0]
    assert set(ledger.loc[ledger["status"] == "kept", "rule"]) == {"split_by_time"}
    assert sorted([*parts["clip_id"], *dropped["clip_id"]]) == clips["clip_id"].tolist()


def test_statistics_are_those_of_the_training_part(run):
    parts, statistics, _ = run(clips_of([(str(n), None) for n in range(30)]))
    trained = parts.loc[parts["part"] == "train", "clip_id"].str[-3:].astype(int) / 1000
    jaw = statistics.set_index("channel").loc["jawOpen"]
    assert jaw["mean"] == pytest.approx(trained.mean())
    assert jaw["high"] == pytest.approx(trained.max())


def test_a_split_repeats_for_a_seed(run):
    clips = clips_of([(str(n), None) for n in range(30)])
    first, again, other = (run(clips, seed=seed)[0] for seed in (3, 3, 4))
    pd.testing.assert_frame_equal(first, again)
    assert not first.equals(other)


def test_no_clip_gives_empty_tables_with_the_reason(run, tmp_path):
    parts, statistics, ledger = run(clips_of([]))
    assert parts.empty
    assert ledger.empty
    assert (statistics["measured"] == 0).all()
    assert tables.reason(tmp_path / "split.parquet") == "no clip came through"

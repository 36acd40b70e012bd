import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.dataset.alike_films import MOST_BITS, alike_films
from mimeline.dataset.alike_motion import Motion, alike_motion
from mimeline.dataset.hamming import MOST_PARTNERS, Words
from mimeline.dataset.near_duplicates import near_duplicates
from mimeline.media.fingerprint import MIRRORED
from mimeline.vocabulary import CHANNELS

SHARE = 0.5


def flipped(word: int, n_bits: int, rng) -> int:
    for bit in rng.permutation(63)[:n_bits]:
        word ^= 1 << int(bit)
    return word


def strangers(n: int, rng) -> np.ndarray:
    return rng.integers(-(2**63), 2**63 - 1, n)


def test_words_that_differ_in_few_bits_are_found_and_no_others():
    rng = np.random.default_rng(0)
    words = strangers(300, rng)
    for distance in range(14):
        words[2 * distance] = flipped(int(words[100 + distance]), distance, rng)
    words[150:200] = np.random.default_rng(1).integers(0, 2**9, 50)  # alike by chance
    groups = np.arange(300) // 3
    differing = (words[:, None] ^ words[None]).view(np.uint64)
    distance = np.unpackbits(differing[..., None].view(np.uint8), axis=-1).sum(-1)  # (n, n)
    expected = (distance <= MOST_BITS) & (groups[:, None] < groups)
    i, j = Words(words, groups).near(words, MOST_BITS)
    assert sorted(zip(i, j, strict=True)) == sorted(zip(*np.nonzero(expected), strict=True))


def test_a_picture_that_thousands_show_ties_them_without_comparing_all_with_all():
    words = np.zeros(2000, np.int64)
    i, j = Words(words, np.arange(2000)).near(words, MOST_BITS)
    assert len(i) < 2000 * MOST_PARTNERS
    assert set(zip(range(1999), range(1, 2000), strict=True)) <= set(zip(i, j, strict=True))


def films(clips: dict[str, list[int]]) -> pd.DataFrame:
    rows = [(clip, 30 * k, bits) for clip, words in clips.items() for k, bits in enumerate(words)]
    return pd.DataFrame(rows, columns=["clip_id", "frame", "bits"])


def alike(clips: dict[str, list[int]], groups: dict[str, str] | None = None) -> pd.DataFrame:
    own = pd.Series({clip: clip for clip in clips} | (groups or {}))
    return alike_films(films(clips), pd.Series(30.0, own.index), own, SHARE)


@pytest.fixture(scope="module")
def scenes() -> np.ndarray:
    return strangers(12, np.random.default_rng(3))


def test_a_part_of_a_film_is_found_with_its_offset_and_share(scenes):
    rng = np.random.default_rng(0)
    part = [flipped(int(word), 5, rng) for word in scenes[4:8]]
    found = alike({"film": list(scenes), "part": [*part, *strangers(1, rng)]}).iloc[0]
    assert found[["clip_id", "other_id"]].tolist() == ["film", "part"]
    assert found["share"] == pytest.approx(0.8)
    assert abs(found["offset_s"] + 4) < 1
    assert not found["mirrored"]


def test_pictures_in_another_order_are_no_film(scenes):
    assert alike({"film": list(scenes), "shuffled": list(scenes[::-1])}).empty


def test_less_than_the_share_is_no_duplicate(scenes):
    rng = np.random.default_rng(0)
    assert alike({"film": list(scenes), "other": [*scenes[:4], *strangers(4, rng)]}).empty
    assert len(alike({"film": list(scenes), "other": [*scenes[:5], *strangers(4, rng)]})) == 1


def test_a_mirrored_film_is_found(scenes):
    found = alike({"film": list(scenes), "mirror": list(scenes ^ MIRRORED)})
    assert found["mirrored"].tolist() == [True]
    assert found["share"].tolist() == [1.0]


def test_clips_of_one_group_are_not_compared(scenes):
    clips = {name: list(scenes) for name in "abc"}
    found = alike(clips, {"a": "x", "b": "x"})
    assert list(zip(found["clip_id"], found["other_id"], strict=True)) == [("a", "c"), ("b", "c")]


def performance(seed: int, n_frames: int = 150, names=tuple(CHANNELS)) -> pd.DataFrame:
    """Channels that move smoothly, each its own way."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames)[:, None] / 30  # (n, 1)
    rate, phase = rng.uniform(0.3, 1.5, (2, len(names)))
    values = 0.3 + 0.2 * np.sin(2 * np.pi * (rate * t + phase)) + rng.normal(0, 0.01, (n_frames, 1))
    return pd.DataFrame(values, columns=list(names)).assign(frame=np.arange(n_frames), valid=True)


def motion_of(takes: dict[str, pd.DataFrame]) -> pd.DataFrame:
    rows = pd.concat([take.assign(clip_id=clip) for clip, take in sorted(takes.items())])
    return rows.reindex(columns=tables.MOTION.schema.names).reset_index(drop=True)


def same_motion(takes: dict[str, pd.DataFrame]) -> pd.DataFrame:
    table = motion_of(takes)
    names = table["clip_id"].unique()
    return alike_motion(Motion(table), pd.Series(names, names), SHARE)


def cut(take: pd.DataFrame, start: int, end: int) -> pd.DataFrame:
    return take.iloc[start:end].assign(frame=np.arange(end - start))


def test_a_take_under_two_names_is_found_rounded_or_cut_anew():
    take = performance(0)
    rounded = take.assign(**take[list(CHANNELS)].round(4))
    found = same_motion({"a": take, "b": rounded, "c": cut(take, 40, 100), "d": performance(1)})
    pairs = list(zip(found["clip_id"], found["other_id"], strict=True))
    assert pairs == [("a", "b"), ("a", "c"), ("b", "c")]
    assert (found["share"] > 0.95).all()
    assert not found["mirrored"].any()


def test_a_mirrored_take_is_found():
    take = performance(0)
    mirror = take.assign(
        **{channel.mirror: channel.mirror_sign * take[name] for name, channel in CHANNELS.items()}
    )
    assert same_motion({"a": take, "b": mirror})["mirrored"].tolist() == [True]


def test_takes_that_share_less_than_the_limit_are_two():
    one, other = performance(0), performance(1)
    one.iloc[:60] = other.iloc[:60]
    assert same_motion({"a": one, "b": other}).empty
    one.iloc[:90] = other.iloc[:90]
    assert same_motion({"a": one, "b": other})["share"].iloc[0] == pytest.approx(0.6, abs=0.02)


@pytest.mark.parametrize("kind", ["constant", "neutral", "unmeasured", "not valid", "one channel"])
def test_frames_that_tell_nothing_are_no_evidence(kind):
    take = performance(0)
    if kind == "constant":
        take[list(CHANNELS)] = take[list(CHANNELS)].iloc[:1].to_numpy().repeat(len(take), axis=0)
    if kind == "neutral":
        take[list(CHANNELS)] = 0.0
    if kind == "unmeasured":
        take[list(CHANNELS)] = np.nan
    if kind == "not valid":
        take["valid"] = False
    if kind == "one channel":
        take[[name for name in CHANNELS if name != "jawOpen"]] = 0.0
    assert same_motion({"a": take, "b": take.copy()}).empty


def test_unmeasured_channels_do_not_make_two_takes_alike():
    names = ["head_yaw_left", "head_pitch_up", "head_tilt_left"]
    one, other = (performance(seed, names=names) for seed in (0, 1))
    assert same_motion({"a": one, "b": other}).empty
    assert len(same_motion({"a": one, "b": one.copy()})) == 1


def duplicates(pictures: dict[str, list[int]], takes: dict[str, pd.DataFrame]) -> pd.DataFrame:
    names = sorted(pictures)
    clips = pd.DataFrame({"clip_id": names, "group": names, "fps_num": 30, "fps_den": 1})
    return near_duplicates(clips, films(pictures), motion_of(takes), SHARE)


def test_films_that_look_alike_but_move_differently_are_two(scenes):
    pictures = {"a": [int(scenes[0])] * 5, "b": [int(scenes[0])] * 5}  # two people in one studio
    assert duplicates(pictures, {"a": performance(0), "b": performance(1)}).empty
    noisy = performance(0)
    noisy[list(CHANNELS)] += np.random.default_rng(0).normal(0, 0.05, (150, len(CHANNELS)))
    found = duplicates(pictures, {"a": performance(0), "b": noisy})  # tracked twice
    assert found["kind"].tolist() == ["film"]
    untracked = performance(0).assign(**dict.fromkeys(CHANNELS, np.nan))
    found = duplicates(pictures, {"a": performance(0), "b": untracked})
    assert found["kind"].tolist() == ["film"]


def test_no_clip_and_no_film_give_no_pair():
    assert duplicates({}, {"a": performance(0).iloc[:0]}).empty
    assert duplicates({"a": [], "b": []}, {"a": performance(0), "b": performance(1)}).empty

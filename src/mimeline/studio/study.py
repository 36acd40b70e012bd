"""The pairs of a study: clips with timelines, to be judged blind.

Ma et al. 2025 ("User Study") ask people whether motion and timeline fit, and whether the motion
looks natural: of real clips with the truth's timeline and with that of the annotation, and of
generated motion with the timeline that it was asked for; 15 pairs of each from the test data. Here
a fourth kind tells who does not look: a clip with the timeline of another.

Nothing that a person is shown may tell the kind. So a track that one of a clip's timelines does not
measure is shown of none, and where motion is drawn it is drawn alike.
"""

import hashlib
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.annotation.annotate import track_codes, unmeasured_actions
from mimeline.errors import BadConfig, NoSuchFile
from mimeline.studio.timelines_of_run import (
    ANNOTATION,
    GENERATION,
    KINDS,
    MISMATCHED,
    TRUTH,
    TimelinesOfRun,
)
from mimeline.vocabulary import CHANNELS, TRACKS, track_actions

PARTS = ("test", "val", "train")  # clips are taken in this order
OTHERS = 5  # clips of which the one that fits least gives a mismatched pair its timeline
DIGITS = 11  # of an id


@dataclass(frozen=True)
class Pair:
    """A clip, and the clip whose timeline it is shown with.

    film: the clip's; None: the clip's motion, or that generated for it, is drawn.
    """

    id: str
    kind: str
    clip_id: str
    timeline_of: str
    film: Path | None

    @property
    def view(self) -> str:
        return "film" if self.film else "face"


@dataclass(frozen=True)
class Track:
    """What is shown of a track. intervals: (action, start, end), in frames, half-open.

    gaps: stretches (start, end) that are not known. absent: actions that are not told of it. A
    track that is not measured has none of these.
    """

    name: str
    measured: bool
    intervals: tuple[tuple[str, int, int], ...]
    gaps: tuple[tuple[int, int], ...]
    absent: tuple[str, ...]


class Study:
    """The same for everybody who gives the same run, pairs, seed and kinds.

    pairs: wanted of each kind. kinds: which; none: all that the run has. filmed: whether films are
    shown: not beside generated motion, or one would see what is real; nor where fewer clips have
    one than pairs are wanted. results: the run's fingerprint. Raises BadConfig for pairs or kinds
    that there cannot be, NoSuchFile where nothing is known of any clip.
    """

    def __init__(self, run: TimelinesOfRun, pairs: int, seed: int, kinds: Sequence[str] = ()):
        if pairs < 1:
            raise BadConfig(
                "--pairs",
                found=str(pairs),
                expected="at least one pair of each kind",
                remedy="Leave it out for the 15 of Ma et al. 2025.",
            )
        for kind in kinds:
            if kind not in run.of_kind:
                raise BadConfig(
                    "--kinds",
                    found=f"{kind}, of which the run has no pair ({run.absent[kind]})"
                    if kind in KINDS
                    else kind,
                    expected=f"some of {', '.join(run.of_kind)}",
                    remedy="Leave it out for all that the run has.",
                )
        self.run, self.seed = run, seed
        self.kinds = tuple(k for k in KINDS if k in (kinds or run.of_kind) and k in run.of_kind)
        self.results = run.fingerprint()
        clips = run.of_kind[ANNOTATION]
        filmed = set() if GENERATION in self.kinds else clips & run.films.keys()
        self.filmed = len(filmed) >= pairs
        order = self._in_order(clips)
        drawn = self._drawn([c for c in order if c in filmed or not self.filmed], pairs)
        others = {clip: self._others(order, clip) for kind, clip in drawn if kind == MISMATCHED}
        clips = {clip for _, clip in drawn} | {clip for own in others.values() for clip in own}
        self._absent, self._codes = self._known(clips)
        if all((codes < 0).all() for codes in self._codes.values()):
            raise NoSuchFile(
                run.results / "annotate",
                found="no track that is known in any of the clips",
                expected="timelines to judge",
                remedy="The report tells what was not measured, or has no name.",
            )
        pairs_drawn = [self._pair(kind, clip, others.get(clip, [])) for kind, clip in drawn]
        self.pairs = {pair.id: pair for pair in pairs_drawn}

    def order(self, person: str) -> list[Pair]:
        """The pairs in the person's own order."""
        rng = np.random.default_rng(_number(self.seed, person))
        pairs = [self.pairs[name] for name in sorted(self.pairs)]
        return [pairs[place] for place in rng.permutation(len(pairs))]

    def n_frames(self, pair: Pair) -> int:
        return self.run.n_frames(pair.clip_id)

    def fps(self, pair: Pair) -> Fraction:
        return self.run.fps(pair.clip_id)

    def tracks(self, pair: Pair) -> list[Track]:
        """What is shown of the pair's timeline, the eight tracks in order."""
        codes = self._codes[TRUTH if pair.kind == TRUTH else ANNOTATION, pair.clip_id]
        if pair.kind == MISMATCHED:
            codes = self._another(pair.clip_id, pair.timeline_of)
        return [self._track(name, own) for name, own in zip(TRACKS, codes, strict=True)]

    @cached_property
    def motion(self) -> dict[str, pd.DataFrame]:
        """Pair's id → `motion` to draw: where generated motion has no channel, none has it.

        A frame of generated motion is valid where the clip's own is.
        """
        pairs = [pair for pair in self.pairs.values() if pair.film is None]
        real = dict(iter(self.run.motion({p.clip_id for p in pairs}).groupby("clip_id")))
        clips = {pair.clip_id for pair in pairs if pair.kind == GENERATION}
        found = {pair.id: real[pair.clip_id] for pair in pairs}
        if not clips:
            return found
        made = self.run.generated(clips)
        lacking = [name for name in CHANNELS if made[name].isna().all()]
        by_clip = dict(iter(made.groupby("clip_id")))
        for pair in pairs:
            if pair.kind == GENERATION:
                valid = real[pair.clip_id][["clip_id", "frame", "valid"]]
                motion = by_clip[pair.clip_id].drop(columns="valid")
                found[pair.id] = valid.merge(motion, on=["clip_id", "frame"])
            found[pair.id] = found[pair.id].assign(**dict.fromkeys(lacking, np.nan))
        return found

    def _in_order(self, clips: Collection[str]) -> list[str]:
        """The clips in the order in which they are taken: the test part first, then by chance."""
        clips = sorted(clips)
        chance = np.random.default_rng(_number(self.seed, "clips")).permutation(len(clips))
        parts = [self.run.parts.get(clip, "") for clip in clips]
        places = [PARTS.index(part) if part in PARTS else len(PARTS) for part in parts]
        return [clips[n] for n in sorted(range(len(clips)), key=lambda n: (places[n], chance[n]))]

    def _drawn(self, order: Sequence[str], pairs: int) -> list[tuple[str, str]]:
        """(kind, clip): the kinds take turns, each the first clip that was taken least often."""
        taken: Counter[str] = Counter()
        left = {k: [c for c in order if c in self.run.of_kind[k]] for k in self.kinds}
        drawn = []
        for _ in range(pairs):
            for kind, own in left.items():
                if own:
                    clip = min(own, key=taken.__getitem__)  # the first of several
                    own.remove(clip)
                    taken[clip] += 1
                    drawn.append((kind, clip))
        return drawn

    def _others(self, order: Sequence[str], clip: str) -> list[str]:
        """A few clips that follow it, of those that are as long where there are any."""
        place = order.index(clip)
        others = [*order[place + 1 :], *order[:place]]
        long = [c for c in others if self.run.n_frames(c) >= self.run.n_frames(clip)]
        return (long or others)[:OTHERS]

    def _pair(self, kind: str, clip: str, others: Sequence[str]) -> Pair:
        other = clip
        if kind == MISMATCHED:
            own = self._codes[ANNOTATION, clip]
            other = max(others, key=lambda name: (own != self._another(clip, name)).mean())
        film = self.run.films[clip] if self.filmed else None
        told = repr((self.results, self.seed, kind, clip, self.filmed)).encode()
        name = f"p{hashlib.sha256(told).hexdigest()[:DIGITS]}"  # no spreadsheet's number
        return Pair(name, kind, clip, other, film)

    def _another(self, clip: str, other: str) -> np.ndarray:
        """The codes of another's timeline at the length of the clip, known where its own are: what
        is not known of the other is neutral, as a gap that the clip has not would tell."""
        own, its = self._codes[ANNOTATION, clip], self._codes[ANNOTATION, other]
        its = its[:, np.arange(own.shape[1]) % its.shape[1]]  # begins again where it is shorter
        return np.where(own < 0, own, np.maximum(its, 0))

    def _known(self, clips: Collection[str]) -> tuple[dict, dict]:
        """Track → its actions that one of the tables does not measure; and (kind, clip) → the
        (8, n_frames) codes of a clip's timelines, -1 where one of them is not known."""
        frames, truth = self.run.frames(clips), self.run.truth(clips)
        both = [(ANNOTATION, frames)] + [(TRUTH, truth)] * (TRUTH in self.kinds)
        absent = {t: {a for _, rows in both for a in unmeasured_actions(rows, t)} for t in TRACKS}
        codes = {
            (kind, clip): self._coded(clip, own, absent)
            for kind, rows in both
            for clip, own in rows.groupby("clip_id")
        }
        for _, clip in [key for key in codes if key[0] == TRUTH]:
            pair = codes[ANNOTATION, clip], codes[TRUTH, clip]
            unknown = (pair[0] < 0) | (pair[1] < 0)
            for own in pair:
                own[unknown] = -1
        return absent, codes

    def _coded(self, clip: str, rows: pd.DataFrame, absent: dict[str, set[str]]) -> np.ndarray:
        codes = np.full((len(TRACKS), self.run.n_frames(clip)), -1)
        at = rows["frame"].to_numpy("int64")
        inside = at < codes.shape[1]
        for own, track in zip(codes, TRACKS, strict=True):
            if len(absent[track]) == len(track_actions(track)):
                continue
            found = track_codes(rows, track, absent[track])
            untold = [n for n, a in enumerate(track_actions(track), 1) if a in absent[track]]
            found[np.isin(found, untold)] = 0
            own[at[inside]] = found[inside]
        return codes

    def _track(self, name: str, codes: np.ndarray) -> Track:
        if (codes < 0).all():
            return Track(name, False, (), (), ())
        starts = np.flatnonzero(np.diff(codes, prepend=-2))
        runs = list(zip(codes[starts], starts, np.append(starts[1:], len(codes)), strict=True))
        actions = track_actions(name)
        return Track(
            name,
            True,
            tuple((actions[code - 1], int(a), int(b)) for code, a, b in runs if code > 0),
            tuple((int(a), int(b)) for code, a, b in runs if code < 0),
            tuple(action for action in actions if action in self._absent[name]),
        )


def _number(*of: object) -> int:
    """A seed of its own for anything."""
    return int.from_bytes(hashlib.sha256(repr(of).encode()).digest()[:8], "big")

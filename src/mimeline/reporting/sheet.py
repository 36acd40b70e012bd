"""A look at the clips: a frame of some that were filmed, of as many people as possible."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.reporting.album import Album, Picture, Shot

SIZE, MOST = 224, 12


@dataclass(frozen=True)
class Card:
    """A clip, and its person (its source where nobody is known)."""

    clip_id: str
    person: str
    shot: Shot


def sheet(clips: pd.DataFrame, frames: pd.DataFrame, album: Album) -> list[Card]:
    """Ask the album for the frames. clips: `clips` kept; frames: the `frames` table."""
    filmed = clips[clips["clip_id"].isin(album.media)]
    person = filmed["subject_id"].fillna(filmed["source_id"])
    turn = person.groupby(person).cumcount()  # the first clips of everybody, then the second ones
    filmed = filmed.assign(person=person, turn=turn).sort_values(["turn", "clip_id"]).head(MOST)
    own = dict(iter(frames[frames["clip_id"].isin(filmed["clip_id"])].groupby("clip_id")))
    return [
        Card(clip.clip_id, clip.person, album.ask(clip.clip_id, _frame(own, clip), SIZE))
        for clip in filmed.sort_values(["person", "clip_id"]).itertuples()
    ]


def shown(cards: list[Card], album: Album) -> list[tuple[Card, Picture]]:
    """The cards whose video could be read."""
    pictures = ((card, album.get(card.shot)) for card in cards)
    return [(card, picture) for card, picture in pictures if picture and picture.filmed]


def _frame(frames: Mapping[str, pd.DataFrame], clip) -> int:
    """The frame with open eyes that is nearest to the middle."""
    middle = int(clip.n_frames) // 2
    own = frames.get(clip.clip_id)
    if own is None:
        return middle
    number = own["frame"].to_numpy("int64")
    closed = own["EyeClose"].fillna(False).to_numpy("bool")
    away = np.abs(number - middle) + len(own) * closed
    return int(number[away.argmin()])

"""The clips' videos: found, cut to a constant rate and cropped; what is there is not cut again."""

import json
import logging
import math
import os
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.atomic import whole
from mimeline.clips.catalogues.celebvtext import LARGEST_SHARE
from mimeline.clips.catalogues.videos import videos_in
from mimeline.clips.failure import failure
from mimeline.errors import MimelineError, unreadable
from mimeline.ledger import Ledger
from mimeline.media.box import Box
from mimeline.media.cut import cut, cut_sound
from mimeline.media.limits import Limits, Refused, check_bytes, check_video
from mimeline.media.probe import Probe, probe
from mimeline.progress import told

log = logging.getLogger(__name__)

SAME_RATE = 0.005  # of a rate: 29.97 and 30 are the same to the eye of a tracker
SIDES = ("top", "bottom", "left", "right")


def fetch(
    clips: Path,
    data: Path,
    kept: Path,
    times: Path,
    fingerprints: Path,
    ledger: Path,
    media: Path,
    sources: Path,
    folder: str | None,
    url: str | None,
    max_height: int,
    attempts: int,
    stall_s: float,
    keep_sources: bool,
    fps: str,
    side_px: int | None,
    max_pixels: int,
    max_source_s: float,
    max_mb: float,
    timeout_s: float,
    recipe: str,
) -> None:
    """Cut each clip out of its video (Höll 2024, 5.2.2).

    clips, kept: `clips` tables in and out; out tells media, audio, size, rate and frames. times:
    the `source_times` table: which frame of the video each frame shows. media: folder that the
    films and sounds are written to and stay in; what no clip needs is removed from it.
    A clip's video is <data>/<folder>/<clip_id>.mp4 (cut already: used from its start, whole
    picture), else <source_id>.mp4 from start_s to end_s, cropped to its box; folder: None where
    there are no videos. A clip without video is kept, with a note.
    fps: frames per second, as 30 or 30000/1001. side_px: edge of a square picture, or None.
    max_pixels (width × height), max_source_s (seconds): limits of a video. max_mb (megabytes): of
    a video, and of each film and sound. timeout_s: of each process that works on a video, seconds.
    recipe: a digest of the code that cuts; what was cut by another is cut anew.
    """
    table = tables.read(tables.CLIPS, clips)
    limits = Limits(max_pixels, max_source_s, max_mb, timeout_s)
    media = Path(media)
    media.mkdir(parents=True, exist_ok=True)
    decisions = Ledger("fetch", table["clip_id"])
    videos = {} if folder is None else videos_in(Path(data) / folder)
    absent = "fetch.folder is null" if folder is None else f"no video of it in {folder}"

    pieces = []
    for clip in table.itertuples():
        if path := videos.get(clip.clip_id):
            pieces.append(_Piece(clip, path, Fraction(fps), side_px, recipe, is_cut=True))
        elif path := videos.get(clip.source_id):
            pieces.append(_Piece(clip, path, Fraction(fps), side_px, recipe, is_cut=False))
        else:
            decisions.note(clip.clip_id, "no_video", detail=absent)

    facts = {}
    for piece, result in _results(sorted(pieces, key=_Piece.order), media, limits):
        if isinstance(result, MimelineError):
            decisions.fail(piece.clip_id, **failure(result))
        else:
            facts[piece.clip_id] = result
            _note_rate(decisions, piece, result["source_rate"])
    _remove_others(media, facts)

    table = table[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.CLIPS, _filled(table, facts, media, Fraction(fps)), kept)
    rows = [_times(clip_id, fact) for clip_id, fact in facts.items()]
    empty = tables.empty(tables.SOURCE_TIMES)
    tables.write(
        tables.SOURCE_TIMES,
        pd.concat(rows) if rows else empty,
        times,
        reason="" if rows else "no clip has a video that could be cut",
    )
    tables.write(tables.FINGERPRINTS, tables.empty(tables.FINGERPRINTS), fingerprints)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)
    if facts:
        log.info("the films are in %s", media)


def _note_rate(decisions: Ledger, piece: "_Piece", rate: float) -> None:
    """Frames that are shown twice or left out look like motion that stops or jumps."""
    fps = float(piece.fps)
    if abs(rate - fps) > SAME_RATE * fps:
        facts = {"value": rate, "limit": fps, "unit": "frames per second"}
        what = "shown twice" if rate < fps else "left out"
        decisions.note(piece.clip_id, "resampled", **facts, detail=f"some frames are {what}")


class _Piece:
    """What is to be cut for a clip: where from, and how."""

    def __init__(
        self, clip, source: Path, fps: Fraction, side_px: int | None, recipe: str, *, is_cut: bool
    ):
        self.clip_id, self.source, self.fps, self.side_px = clip.clip_id, source, fps, side_px
        self.recipe = recipe
        self.start_s = 0.0 if is_cut else clip.start_s
        self.length_s = clip.end_s - clip.start_s
        edges = [float(getattr(clip, f"bbox_{side}")) for side in SIDES]
        self.edges = None if is_cut or not np.isfinite(edges).all() else edges

    def order(self) -> tuple:
        return self.source, self.start_s, self.clip_id

    @property
    def n_frames(self) -> int:
        return max(1, round(self.length_s * self.fps))

    def key(self, status: os.stat_result) -> dict:
        """All that the cut file depends on."""
        return {
            "recipe": self.recipe,
            "source": self.source.name,
            "size": status.st_size,
            "mtime_ns": status.st_mtime_ns,
            "start_s": self.start_s,
            "n_frames": self.n_frames,
            "fps": str(self.fps),
            "edges": self.edges,
            "side_px": self.side_px,
        }

    def box(self, video: Probe) -> Box:
        """The part of the picture in pixels; the table has pixels, or shares of the picture."""
        if self.edges is None:
            return Box.whole(video.width, video.height)
        if max(self.edges) <= LARGEST_SHARE:
            return Box.of_shares(*self.edges, video.width, video.height)
        return Box(*self.edges)


def _results(pieces: list[_Piece], media: Path, limits: Limits) -> Iterable[tuple]:
    """Each piece with the facts of its file, or with the error that stands in its way.

    Pieces come in the order of their videos, so that each video is looked into once.
    """
    source, video = None, None
    for piece in told(pieces, "clips", log):
        try:
            if not math.isfinite(piece.length_s) or piece.length_s > limits.max_source_s:
                raise _too_long(piece, limits)
            key = piece.key(_status(piece.source))
            check_bytes(piece.source, key["size"], limits)
            fact = _remembered(piece, key, media)
            if fact is None:
                if source != piece.source:
                    source, video = piece.source, _probed(piece.source, limits)
                if isinstance(video, MimelineError):
                    raise video
                fact = _make(piece, video, key, media, limits)
            size = fact["source_width"], fact["source_height"], fact["source_s"]
            check_video(piece.source, *size, limits)
            film, sound, _ = _files(media, piece.clip_id)
            for path, n_bytes in zip((film, sound), fact["bytes"], strict=True):
                check_bytes(path, n_bytes or 0, limits)
            yield piece, fact
        except MimelineError as error:
            yield piece, error


def _status(path: Path) -> os.stat_result:
    try:
        return path.stat()
    except OSError as error:
        remedy = "Take the video again, or mend the link to it."
        raise unreadable(path, error, expected="a video", remedy=remedy) from error


def _too_long(piece: _Piece, limits: Limits) -> Refused:
    return Refused(
        piece.source,
        rule="too_long",
        value=piece.length_s,
        limit=limits.max_source_s,
        unit="s",
        found=f"a clip of {piece.length_s:g} s",
        expected=f"at most {limits.max_source_s:g} s",
        remedy="Check the catalogue's times, or raise fetch.max_source_s.",
    )


def _probed(path: Path, limits: Limits) -> Probe | MimelineError:
    try:
        return probe(path, limits)
    except MimelineError as error:
        return error


def _make(piece: _Piece, video: Probe, key: dict, media: Path, limits: Limits) -> dict:
    """Cut the piece's film and sound; the note beside them is written last."""
    film, sound, note = _files(media, piece.clip_id)
    for path in (note, film, sound):
        path.unlink(missing_ok=True)
    shown = cut(
        piece.source,
        video,
        film,
        start_s=piece.start_s,
        n_frames=piece.n_frames,
        fps=piece.fps,
        box=piece.box(video),
        side_px=piece.side_px,
        limits=limits,
    )
    if video.has_sound:
        length_s = float(piece.n_frames / piece.fps)
        cut_sound(
            piece.source, video, sound, start_s=piece.start_s, length_s=length_s, limits=limits
        )
    *_, width, height = piece.box(video).within(video.width, video.height)
    fact = {
        "width": piece.side_px or width,
        "height": piece.side_px or height,
        "n_frames": len(shown),
        "bytes": [_size(film), _size(sound)],
        "source_width": video.width,
        "source_height": video.height,
        "source_s": video.duration_s,
        "source_rate": float(video.rate),
        "shown": shown.tolist(),
        "shown_s": video.times[shown].tolist(),
    }
    with whole(note) as temporary:
        temporary.write_text(json.dumps({"key": key, "fact": fact}))
    return fact


def _remembered(piece: _Piece, key: dict, media: Path) -> dict | None:
    """The facts of a file that was cut before in the very same way; None where it was not."""
    film, sound, note = _files(media, piece.clip_id)
    try:
        content = json.loads(note.read_text())
        fact = content["fact"]
        same = content["key"] == key and fact["bytes"] == [_size(film), _size(sound)]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return fact if same else None


def _size(path: Path) -> int | None:
    """Bytes of a file; None where there is none."""
    return path.stat().st_size if path.is_file() else None


def _has_sound(fact: dict) -> bool:
    return fact["bytes"][1] is not None


def _files(media: Path, clip_id: str) -> tuple[Path, Path, Path]:
    """A clip's film, its sound and the note of what they were made from."""
    return media / f"{clip_id}.mp4", media / f"{clip_id}.wav", media / f"{clip_id}.json"


def _remove_others(media: Path, facts: dict[str, dict]) -> None:
    ours = set()
    for clip_id, fact in facts.items():
        film, sound, note = _files(media, clip_id)
        ours |= {film, note} | ({sound} if _has_sound(fact) else set())
    for path in media.iterdir():
        if path.is_file() and path not in ours:
            path.unlink()


def _filled(table: pd.DataFrame, facts: dict, media: Path, fps: Fraction) -> pd.DataFrame:
    """The clips with what is known of their films."""
    table = table.set_index("clip_id", drop=False)
    for clip_id, fact in facts.items():
        film, sound, _ = _files(media, clip_id)
        table.loc[clip_id, "media"] = str(film)
        if _has_sound(fact):
            table.loc[clip_id, "audio"] = str(sound)
        for column in ("width", "height", "n_frames"):
            table.loc[clip_id, column] = fact[column]
        table.loc[clip_id, ["fps_num", "fps_den"]] = fps.numerator, fps.denominator
    return table.reset_index(drop=True)


def _times(clip_id: str, fact: dict) -> pd.DataFrame:
    shown, seconds = fact["shown"], fact["shown_s"]
    return pd.DataFrame(
        {
            "clip_id": clip_id,
            "frame": np.arange(len(shown)),
            "source_frame": shown,
            "source_s": seconds,
        }
    )

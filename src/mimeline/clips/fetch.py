"""The clips' videos: found or taken, cut to a constant rate and cropped; what is there stays."""

import logging
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.clips import film
from mimeline.clips.download import Download, Terms, remove_leftovers
from mimeline.clips.failure import failure
from mimeline.clips.piece import Piece
from mimeline.clips.source import LocalSource, local_videos
from mimeline.errors import BadFile, MimelineError
from mimeline.ledger import Ledger
from mimeline.media.limits import Limits, check_bytes, check_video
from mimeline.media.remote import NotTaken
from mimeline.progress import told

log = logging.getLogger(__name__)

SAME_RATE = 0.005  # of a rate: 29.97 and 30 are the same to the eye of a tracker
OF_THE_MOMENT = ("timed_out", "unreachable")  # a download may serve the next run
PAUSE_S = 5.0  # before a download is tried again, at first


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
    pause_s: float = PAUSE_S,
) -> None:
    """Cut each clip out of its video (Höll 2024, 5.2.2).

    clips, kept: `clips` tables in and out; out tells media, audio, size, rate and frames. times:
    the `source_times` table: which frame of the video each frame shows. fingerprints: what the
    films look like. media: folder that the films and sounds are written to and stay in; what no
    clip needs is removed from it. sources: folder of downloads, and of notes of what is gone.
    A clip's video is the one that the catalogue names; else <data>/<folder>/<clip_id>.mp4 (cut
    already: used from its start, whole picture), else <source_id>.mp4 there; folder: None where
    there are none; else what lies at url, None: nothing is downloaded. Of a source it is start_s to
    end_s, cropped to its box. A clip without video is kept, with a note.
    A source of one clip is taken in part, one of several whole, and removed after unless
    keep_sources. max_height: pixels. attempts: of a download that may succeed. stall_s: silence
    that ends an attempt, seconds. pause_s: before the second attempt, seconds; it grows.
    fps: frames per second, as 30 or 30000/1001. side_px: edge of a square picture, or None.
    max_pixels (width × height), max_source_s (seconds): limits of a video. max_mb (megabytes): of
    a video, and of each film and sound. timeout_s: of each process that works on a video, seconds.
    recipe: a digest of the code that cuts; what was cut by another is cut anew.
    Raises BadConfig if something is to be downloaded and yt-dlp is not installed; OSError if the
    disk is full, which leaves what is done.
    """
    table = tables.read(tables.CLIPS, clips)
    limits = Limits(max_pixels, max_source_s, max_mb, timeout_s)
    media = Path(media)
    media.mkdir(parents=True, exist_ok=True)
    decisions = Ledger("fetch", table["clip_id"])
    terms = None
    if url is not None:
        how = (max_height, attempts, stall_s, keep_sources, pause_s)
        terms = Terms(Path(sources), url, *how)
    work = []
    for clip, source, is_cut in _with_sources(table, Path(data), folder, terms, limits):
        if source is None:
            absent = "fetch.folder is null" if folder is None else f"no video of it in {folder}"
            decisions.note(clip.clip_id, "no_video", detail=absent)
        else:
            work.append((source, Piece(clip, Fraction(fps), side_px, is_cut=is_cut)))

    facts = {}
    for piece, fact, row in _results(work, media, limits, recipe):
        if fact is None:
            decisions.fail(piece.clip_id, **row)
        else:
            facts[piece.clip_id] = fact
            _note_rate(decisions, piece, fact["source_rate"])
    if terms is not None:
        remove_leftovers(terms, set(table["source_id"]))
    _remove_others(media, facts, {p.clip_id for source, p in work if source.lasting})

    table = table[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.CLIPS, _filled(table, facts, media, Fraction(fps)), kept)
    reason = "" if facts else "no clip has a video that could be cut"
    tables.write(tables.SOURCE_TIMES, _times(facts), times, reason=reason)
    tables.write(tables.FINGERPRINTS, _fingerprints(facts), fingerprints, reason=reason)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)
    if facts:
        log.info("the films are in %s", media)


def _with_sources(
    table: pd.DataFrame, data: Path, folder: str | None, terms: Terms | None, limits: Limits
) -> Iterator[tuple]:
    """Each clip with its source, or None, and whether that is the clip itself."""
    if terms is not None and folder is not None and not (data / folder).is_dir():
        folder = None  # all is downloaded
    here: dict[tuple, LocalSource] = {}
    elsewhere = []
    for clip, path, is_cut in local_videos(table, data, folder):
        if path is None:
            elsewhere.append(clip)
            continue
        within = data if isinstance(clip.video, str) else None
        if (path, within) not in here:
            here[path, within] = LocalSource(path, limits, within=within)
        yield clip, here[path, within], is_cut
    counts = Counter(clip.source_id for clip in elsewhere)
    downloads = {
        source_id: terms and Download(source_id, terms, limits, alone=count == 1)
        for source_id, count in counts.items()
    }
    for clip in elsewhere:
        yield clip, downloads[clip.source_id], False


def _results(work: list[tuple], media: Path, limits: Limits, recipe: str) -> Iterator[tuple]:
    """Each piece with the facts of its film, or with the row that says what stands in its way.

    Pieces come source by source, so that each is opened once and given back.
    """
    order = {id(source): number for number, (source, _) in enumerate(work)}
    work = sorted(work, key=lambda item: (order[id(item[0])], item[1].start_s, item[1].clip_id))
    left = Counter(id(source) for source, _ in work)
    settled = True
    for source, piece in told(work, "clips", log):
        fact, row = None, {"rule": ""}
        try:
            fact = _fact(source, piece, media, limits, recipe)
        except NotTaken as error:
            row = {"rule": error.rule, "detail": failure(error)["detail"]}
        except _Known as known:
            row = known.row
        except MimelineError as error:
            row = failure(error)
        settled &= row["rule"] not in OF_THE_MOMENT
        left[id(source)] -= 1
        if not left[id(source)]:
            source.close(settled=settled)
            settled = True
        yield piece, fact, row


class _Known(Exception):
    """The note says why the clip cannot be cut out of its download. row: the ledger's."""

    def __init__(self, row: dict):
        self.row = row


def _fact(source, piece: Piece, media: Path, limits: Limits, recipe: str) -> dict:
    """The facts of the piece's film, which is made unless it is there."""
    piece.check_length(limits)
    key = {"recipe": recipe} | source.key() | piece.key()
    known = film.in_mind(media, piece.clip_id, key)
    if (stamp := source.stamp()) is not None and known.get("stamp") != stamp:
        known = {}
    if known.get("limits") == asdict(limits):
        raise _Known(known["failed"])
    fact = known.get("fact")
    if fact is None:
        try:
            fact = _made(source, piece, media, limits)
        except BadFile as error:
            if source.lasting and (row := failure(error))["rule"] != "timed_out":
                facts = {"failed": row, "limits": asdict(limits), "stamp": source.stamp()}
                film.keep_in_mind(media, piece.clip_id, key, **facts)
            raise
        film.keep_in_mind(media, piece.clip_id, key, fact=fact, stamp=source.stamp())
    size = fact["source_width"], fact["source_height"], fact["source_s"]
    check_video(source.name, *size, limits)
    for path, n_bytes in zip(film.files(media, piece.clip_id), fact["bytes"], strict=False):
        check_bytes(path, n_bytes or 0, limits)
    return fact


def _made(source, piece: Piece, media: Path, limits: Limits) -> dict:
    footage = source.footage(piece.start_s, piece.start_s + piece.length_s)
    try:
        return film.make(piece, footage, media, limits)
    except BadFile as error:
        if error.file == str(footage.path):
            error.file = str(source.name)  # a download is gone when this is read
        raise


def _note_rate(decisions: Ledger, piece: Piece, rate: float) -> None:
    """Frames that are shown twice or left out look like motion that stops or jumps."""
    fps = float(piece.fps)
    if abs(rate - fps) > SAME_RATE * fps:
        facts = {"value": rate, "limit": fps, "unit": "frames per second"}
        what = "shown twice" if rate < fps else "left out"
        decisions.note(piece.clip_id, "resampled", **facts, detail=f"some frames are {what}")


def _remove_others(media: Path, facts: dict[str, dict], lasting: set[str]) -> None:
    """Remove what no clip needs. lasting: clips whose notes stay also where there is no film."""
    ours = {film.files(media, clip_id)[2] for clip_id in lasting}
    for clip_id, fact in facts.items():
        path, sound, note = film.files(media, clip_id)
        ours |= {path, note} | ({sound} if _has_sound(fact) else set())
    for path in media.iterdir():
        if path.is_file() and path not in ours:
            path.unlink()


def _has_sound(fact: dict) -> bool:
    return fact["bytes"][1] is not None


def _filled(table: pd.DataFrame, facts: dict, media: Path, fps: Fraction) -> pd.DataFrame:
    """The clips with what is known of their films."""
    table = table.set_index("clip_id", drop=False)
    for clip_id, fact in facts.items():
        path, sound, _ = film.files(media, clip_id)
        table.loc[clip_id, "media"] = str(path)
        if _has_sound(fact):
            table.loc[clip_id, "audio"] = str(sound)
        for column in ("width", "height", "n_frames"):
            table.loc[clip_id, column] = fact[column]
        table.loc[clip_id, ["fps_num", "fps_den"]] = fps.numerator, fps.denominator
    return table.reset_index(drop=True)


def _times(facts: dict[str, dict]) -> pd.DataFrame:
    """The `source_times` table."""
    rows = []
    for clip_id, fact in facts.items():
        seconds = np.array(fact["shown_s"])  # (n_frames,)
        frames = np.arange(len(seconds))
        shown = pd.array(fact["shown"] or [None] * len(seconds), "Int64")
        columns = {"frame": frames, "source_frame": shown, "source_s": seconds}
        rows.append(pd.DataFrame({"clip_id": clip_id} | columns))
    return pd.concat(rows) if rows else tables.empty(tables.SOURCE_TIMES)


def _fingerprints(facts: dict[str, dict]) -> pd.DataFrame:
    """The `fingerprints` table."""
    rows = [
        (clip_id, frame, bits)
        for clip_id, fact in facts.items()
        for frame, bits in zip(fact["looked_at"], fact["bits"], strict=True)
    ]
    if not rows:
        return tables.empty(tables.FINGERPRINTS)
    return pd.DataFrame(rows, columns=["clip_id", "frame", "bits"])

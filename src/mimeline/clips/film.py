"""A clip's film and sound, and the note beside them that tells what they were made from."""

import json
from pathlib import Path

from mimeline.atomic import whole
from mimeline.clips.piece import Piece
from mimeline.clips.source import Footage
from mimeline.media.cut import cut, cut_sound
from mimeline.media.fingerprint import fingerprint
from mimeline.media.limits import Limits


def make(piece: Piece, footage: Footage, media: Path, limits: Limits) -> dict:
    """Cut the piece's film and sound out of the footage, and tell what they are.

    Raises BadFile if the footage cannot be cut so; Refused beyond the limits.
    """
    source, video, whole_s = footage
    film, sound, note = files(media, piece.clip_id)
    for path in (note, film, sound):
        path.unlink(missing_ok=True)
    box = piece.box(video)
    shown = cut(
        source,
        video,
        film,
        start_s=piece.start_s,
        n_frames=piece.n_frames,
        fps=piece.fps,
        box=box,
        side_px=piece.side_px,
        limits=limits,
    )
    if video.has_sound:
        length_s = float(piece.n_frames / piece.fps)
        cut_sound(source, video, sound, start_s=piece.start_s, length_s=length_s, limits=limits)
    *_, width, height = box.within(video.width, video.height)
    frames, bits = fingerprint(film)
    before = video.first_frame
    return {
        "width": piece.side_px or width,
        "height": piece.side_px or height,
        "n_frames": len(shown),
        "bytes": sizes(media, piece.clip_id),
        "source_width": video.width,
        "source_height": video.height,
        "source_s": whole_s,
        "source_rate": float(video.rate),
        "shown": None if before is None else (before + shown).tolist(),
        "shown_s": (video.times[shown] - video.ahead_s).tolist(),
        "looked_at": frames.tolist(),
        "bits": bits.tolist(),
    }


def keep_in_mind(media: Path, clip_id: str, key: dict, **outcome) -> None:
    """Write the note; it comes last, so that what it tells of is whole.

    outcome: stamp, of the download it was made from; fact, of a film that was made, or failed, the
    row of the ledger that says why none can be.
    """
    note = files(media, clip_id)[2]
    with whole(note) as temporary:
        temporary.write_text(json.dumps({"key": key} | outcome))


def in_mind(media: Path, clip_id: str, key: dict) -> dict:
    """What the note tells, if all that it depends on is the same; else nothing."""
    try:
        content = json.loads(files(media, clip_id)[2].read_text())
        same = content["key"] == key
        if "fact" in content:
            same = same and content["fact"]["bytes"] == sizes(media, clip_id)
    except (OSError, ValueError, KeyError, TypeError):
        return {}
    return content if same else {}


def files(media: Path, clip_id: str) -> tuple[Path, Path, Path]:
    """A clip's film, its sound and the note of what they were made from."""
    return media / f"{clip_id}.mp4", media / f"{clip_id}.wav", media / f"{clip_id}.json"


def sizes(media: Path, clip_id: str) -> list[int | None]:
    """Bytes of the film and of the sound; None where there is none."""
    return [p.stat().st_size if p.is_file() else None for p in files(media, clip_id)[:2]]

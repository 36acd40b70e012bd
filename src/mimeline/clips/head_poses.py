"""The head's angles of clips from tables that another tool wrote, one for all or one for each."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from mimeline.errors import MimelineError, NoSuchFile
from mimeline.tracking.firewall import of_the_set_up
from mimeline.tracking.formats import openface, sixdrepnet
from mimeline.vocabulary import HEAD

BEYOND = 0.05  # of a clip's frames: a table that goes on for more is of another clip, or rate


@dataclass(frozen=True)
class Format:
    """What reads tables of a format: one of all clips, with a clip_id, and one of a single clip.

    unit: of the angles in them.
    """

    read_all: Callable[[Path, Collection[str]], pd.DataFrame]
    read_one: Callable[[Path], pd.DataFrame]
    unit: str


FORMATS: Mapping[str, Format] = {
    "sixdrepnet": Format(sixdrepnet.read_sixdrepnet, sixdrepnet.read_head, "degrees"),
    "openface": Format(openface.read_heads, openface.read_head, "radians"),
}


def head_poses(clips: pd.DataFrame, path: Path, format: str) -> tuple[pd.DataFrame, dict[str, str]]:
    """Head angles of the clips' own frames, and what there is to say of a clip.

    clips: clip_id, source_id, start_s, fps_num, fps_den, n_frames. path: a table of all clips, or
    a folder of <clip_id>.csv, whose first frame is the clip's, or <source_id>.csv, whose first
    frame is the source's. Such a table is taken to be at the clip's rate: the clip begins at its
    frame round(start_s * fps).
    Returns clip_id, frame and the angles (radians, NaN where unknown); clip_id → remark.
    Raises MimelineError where the table, the folder or most of the folder's tables cannot be read.
    """
    path, reader = Path(path), FORMATS[format]
    if path.is_dir():
        return _of_folder(clips, path, reader)
    if not path.exists():
        raise NoSuchFile(
            path,
            found="no such file or folder",
            expected=f"head poses of {format}",
            remedy=f"Name it in pose.{format}.file, or set pose.format: motion.",
        )
    remarks: dict[str, str] = {}
    rows = reader.read_all(path, set(clips["clip_id"]))
    return _inside(rows.merge(clips[["clip_id", "n_frames"]], on="clip_id"), remarks), remarks


def _of_folder(
    clips: pd.DataFrame, folder: Path, reader: Format
) -> tuple[pd.DataFrame, dict[str, str]]:
    parts: list[pd.DataFrame] = []
    remarks: dict[str, str] = {}
    tables: dict[Path, pd.DataFrame | MimelineError] = {}
    for clip in clips.sort_values(["source_id", "clip_id"]).itertuples():
        own, whole = folder / f"{clip.clip_id}.csv", folder / f"{clip.source_id}.csv"
        path = own if own.is_file() else whole
        if not path.is_file():
            remarks[clip.clip_id] = f"there is no {own.name} in {folder.name}, nor {whole.name}"
            continue
        if path not in tables:
            tables[path] = _read(reader, path)
        table = tables[path]
        if isinstance(table, MimelineError):
            remarks[clip.clip_id] = str(table)
            continue
        if path == whole and own != whole:
            start = round(clip.start_s * clip.fps_num / clip.fps_den)
            table = table.assign(frame=table["frame"] - start)
            table = table[table["frame"].between(0, clip.n_frames - 1)]
        parts.append(table.assign(clip_id=clip.clip_id, n_frames=clip.n_frames))
    errors = [table for table in tables.values() if isinstance(table, MimelineError)]
    if errors and of_the_set_up(len(errors), len(tables)):
        raise errors[0]
    columns = ["clip_id", "frame", "n_frames", *HEAD]
    rows = pd.concat(parts) if parts else pd.DataFrame(columns=columns)
    return _inside(rows, remarks), remarks


def _read(reader: Format, path: Path) -> pd.DataFrame | MimelineError:
    try:
        return reader.read_one(path)
    except MimelineError as error:
        return error


def _inside(rows: pd.DataFrame, remarks: dict[str, str]) -> pd.DataFrame:
    """Rows of the clips' own frames; what lies far beyond them is remarked on."""
    last = rows.groupby("clip_id")[["frame", "n_frames"]].max()
    for clip_id, (frame, n_frames) in last.iterrows():
        if frame >= (1 + BEYOND) * n_frames:
            remarks[clip_id] = (
                f"the table goes on to frame {frame}, the clip has {n_frames}: "
                "is it of this clip, and at its rate?"
            )
    inside = rows["frame"].between(0, rows["n_frames"] - 1)
    return rows.loc[inside, ["clip_id", "frame", *HEAD]].reset_index(drop=True)

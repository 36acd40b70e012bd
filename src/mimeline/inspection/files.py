"""Files that are no takes: videos, a run's tables, head poses, face models."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from mimeline import tables
from mimeline.errors import MimelineError
from mimeline.inspection.inspection import Inspection
from mimeline.media.limits import Limits
from mimeline.media.probe import probe
from mimeline.tracking import loss
from mimeline.tracking.formats.sixdrepnet import read_sixdrepnet
from mimeline.vocabulary import EXPRESSIONS, canonical

FACES = (".npz", ".pkl")  # endings of face models in one file
LOSSES = "tracking losses of a take"
GLANCE = 1 << 16  # bytes of a file that are looked at to tell what it is
TABLES = {
    table.name if region is None else f"{table.name} of the {region} region": table
    for region, table in [
        *((None, table) for table in vars(tables).values() if isinstance(table, tables.Table)),
        *((None, table) for table in tables.COEFFICIENTS.values()),
        *((f"{side} {region}", table) for (region, side), table in tables.SERIES.items()),
    ]
}


def video(path: Path) -> Inspection:
    """A video, as the stage fetch would see it."""
    seen = Inspection(path, "video")
    try:
        found = probe(path, Limits())
    except MimelineError as error:
        seen.error = str(error)
        return seen
    variable = " (variable)" if found.variable else ""
    seen.facts = {
        "size": f"{found.width} × {found.height}",
        "fps": f"{float(found.rate):.5g}{variable}",
        "frames": str(found.n_frames),
        "length": f"{found.duration_s:.2f} s",
        "codec": f"{found.codec} in {found.container}",
        "sound": "yes" if found.has_sound else "none",
    }
    if found.variable:
        seen.notes.append("its frames last unequally long: fetch cuts it to a constant rate")
    seen.numbers = {
        "width": found.width,
        "height": found.height,
        "fps": str(found.rate),
        "variable": found.variable,
        "frames": found.n_frames,
        "seconds": found.duration_s,
        "codec": found.codec,
        "container": found.container,
        "sound": found.has_sound,
    }
    return seen


def table(path: Path) -> Inspection | None:
    """A table of a run, and whether it keeps its contract; None for any other Parquet file."""
    name = table_name(path)
    if name is None:
        return None
    seen = Inspection(path, f"table {name}")
    try:
        rows = tables.read(TABLES[name], path)
    except MimelineError as error:
        seen.error = str(error)
        return seen
    seen.facts = {"rows": str(len(rows)), "columns": str(rows.shape[1])}
    seen.numbers = {"table": name, "rows": len(rows)}
    if "clip_id" in rows:
        seen.numbers["clips"] = rows["clip_id"].nunique()
        seen.facts["clips"] = str(seen.numbers["clips"])
    if "stage" in rows and "status" in rows and len(rows):
        counts = rows.groupby(["stage", "status"], sort=False).size()
        seen.facts["decisions"] = ", ".join(
            f"{n} {status} at {stage}" for (stage, status), n in counts.items()
        )
    seen.facts["contract"] = "kept: types, values and keys as declared"
    if reason := tables.reason(path):
        seen.notes.append(f"empty because {reason}")
    return seen


def table_name(path: Path) -> str | None:
    """Which table a Parquet file is: by its columns, else by its name; None where it is neither."""
    return table_by_columns(path) or (path.stem if path.stem in TABLES else None)


def table_by_columns(path: Path) -> str | None:
    """The table of a run whose columns a Parquet file has; None for any other file."""
    if path.suffix.lower() != ".parquet" or not path.is_file():
        return None
    columns = columns_of(path)
    return next((name for name, table in TABLES.items() if table.schema.names == columns), None)


def columns_of(path: Path) -> list[str]:
    """The columns of a Parquet file; none where it cannot be read."""
    try:
        return pq.read_schema(path).names
    except (pa.ArrowException, OSError, ValueError):
        return []


def is_losses(path: Path) -> bool:
    """Whether a file is named as the sidecar that holds a take's tracking losses."""
    return path.name.lower().endswith(".loss.csv") and path.is_file()


def losses(path: Path) -> Inspection:
    """The sidecar of a take: its tracking loss in every frame."""
    seen = Inspection(path, LOSSES)
    try:
        values = loss.sidecar(path.with_name(path.name[: -len(".loss.csv")] + ".csv"))
    except MimelineError as error:
        seen.error = str(error)
        return seen
    if values is not None:
        seen.numbers = {"rows": len(values)}
        seen.facts = {"rows": str(len(values))}
    return seen


def is_head_poses(path: Path) -> bool:
    """Whether a file is a table of 6DRepNet's angles, by its header."""
    header = glance(path).partition(b"\n")[0].decode("utf-8", errors="replace")
    return {"clip_id", "pitch", "yaw", "roll"} <= {name.strip() for name in header.split(",")}


def head_poses(path: Path) -> Inspection | None:
    """A 6DRepNet table of head poses; None for any other file."""
    if not is_head_poses(path):
        return None
    seen = Inspection(path, "6DRepNet table")
    try:
        rows = read_sixdrepnet(path)
    except MimelineError as error:
        seen.error = str(error)
        return seen
    widest = np.degrees(rows["head_yaw_left"].abs().max())
    seen.numbers = {"rows": len(rows), "clips": rows["clip_id"].nunique()}
    seen.facts = {
        "rows": str(len(rows)),
        "clips": str(seen.numbers["clips"]),
        "yaw": f"up to {widest:.0f}° to either side",
    }
    return seen


def face(path: Path) -> Inspection:
    """A face model: its file, or its folder."""
    from mimeline.face.load import load_face  # loads slowly, and is needed seldom

    seen = Inspection(path, "face model")
    try:
        found = load_face(path)
    except MimelineError as error:
        seen.error = str(error)
        return seen
    named = {canonical(name) for name in found.shape_names} & set(EXPRESSIONS)
    seen.facts = {
        "vertices": str(len(found.neutral)),
        "shapes": f"{len(found.shape_names)}, of which {len(named)} bear names of ARKit channels",
        "identities": str(len(found.identity_names)),
        "joints": ", ".join(found.joint_names) or "none",
    }
    seen.numbers = {"vertices": len(found.neutral), "shapes": list(found.shape_names)}
    return seen


def glance(path: Path) -> bytes:
    """How a file begins; nothing where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(GLANCE)
    except OSError:
        return b""

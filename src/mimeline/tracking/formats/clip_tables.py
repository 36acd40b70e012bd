"""A CSV of many clips, of any size, told apart by its column clip_id."""

import warnings
from collections.abc import Collection
from pathlib import Path

import pandas as pd
from pandas.errors import DtypeWarning

from mimeline.errors import BadFile, MissingColumn, unreadable
from mimeline.tracking.formats.columns import names_of

ROWS = 500_000  # read at once; of these only the clips' stay


def read_clips(
    path: Path, needed: tuple[str, ...], known: tuple[str, ...], clips: Collection[str] | None
) -> pd.DataFrame:
    """clip_id, the needed columns and those of the known that there are, cells as they stand.

    The file may write names in any case and with blanks around them. clips: whose rows to keep;
    None: all. Rows are numbered as in the file, from 0.
    Raises MissingColumn, or BadFile for a file that is no table.
    """
    header = names_of(path)
    wanted = ("clip_id", *needed, *known)
    folded = [name.casefold() for name in header]
    places = {n: folded.index(n.casefold()) for n in wanted if n.casefold() in folded}
    if header and (missing := [name for name in ("clip_id", *needed) if name not in places]):
        raise MissingColumn(
            path,
            place="line 1",
            found="columns " + ", ".join(header)[:80],
            expected=", ".join(missing),
            remedy="Head the columns so, in one table of all clips; or name a folder of tables.",
        )
    parts = []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DtypeWarning)  # numbers amid text are looked at later
            for part in pd.read_csv(
                path,
                header=0,
                names=range(len(header)),
                index_col=False,
                usecols=list(places.values()),
                dtype={places.get("clip_id", 0): str},
                na_filter=False,
                skipinitialspace=True,
                encoding="utf-8-sig",
                compression=None,
                chunksize=ROWS,
            ):
                part = part[list(places.values())].set_axis(list(places), axis=1)
                part["clip_id"] = part["clip_id"].str.strip()
                keep = part["clip_id"] != ""
                parts.append(part[keep if clips is None else keep & part["clip_id"].isin(clips)])
    except (ValueError, OSError) as error:
        raise unreadable(
            path,
            error,
            expected="a CSV table with a header",
            remedy="Write the table again, or set pose.format: motion.",
        ) from error
    if not parts:
        raise BadFile(
            path, found="no row", expected="a row per frame", remedy="Write the table again."
        )
    return pd.concat(parts)

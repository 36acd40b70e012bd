"""Which reader reads which format."""

from pathlib import Path

from mimeline.tracking import livelink, pyfeat
from mimeline.tracking.take import Take

READERS = {"livelink": livelink.read, "pyfeat": pyfeat.read}


def read_take(path: Path, format: str, options: dict, bad_values: str) -> Take:
    """A tracking result of the named format; options are the format's keys but the folder."""
    reading = {key: value for key, value in options.items() if key != "folder"}
    return READERS[format](Path(path), bad_values=bad_values, **reading)

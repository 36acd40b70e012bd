"""`mimeline inspect`: what a file or folder is, and what is wrong with it."""

from mimeline.inspection.inspection import Inspection, Range
from mimeline.inspection.kinds import inspect
from mimeline.inspection.options import Options, options
from mimeline.inspection.text import as_json, as_text

__all__ = ["Inspection", "Options", "Range", "as_json", "as_text", "inspect", "options"]

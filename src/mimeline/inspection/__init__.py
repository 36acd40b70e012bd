"""What a file or folder is, and what became of a run's clips: inspect, why and funnel."""

from mimeline.inspection.inspection import Inspection, Range
from mimeline.inspection.kinds import inspect
from mimeline.inspection.options import Options, options
from mimeline.inspection.text import as_json, as_text

__all__ = ["Inspection", "Options", "Range", "as_json", "as_text", "inspect", "options"]

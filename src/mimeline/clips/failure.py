"""What stands in a clip's way, as a row of the ledger."""

from mimeline.errors import MimelineError
from mimeline.media.limits import Refused


def failure(error: MimelineError) -> dict:
    """The rule and facts that `Ledger.fail` takes: the error's own, else that it is unreadable."""
    detail = spelt_out(str(error))
    if not isinstance(error, Refused):
        return {"rule": "unreadable", "detail": detail}
    numbers = {"value": error.value, "limit": error.limit, "unit": error.unit}
    return {"rule": error.rule, "detail": detail} | numbers


def spelt_out(text: str) -> str:
    """The text as any file and any terminal may hold it: what cannot be printed is spelt out."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)

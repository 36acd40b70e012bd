"""A page that is complete in itself: its template filled in, its colours and styles inside."""

import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2

from mimeline import __version__
from mimeline.atomic import whole
from mimeline.reporting import words
from mimeline.reporting.style import themes

TEMPLATES = Path(__file__).parent / "templates"
FILTERS = ("spaced", "short", "percent", "count", "clips", "score", "number")


def write_page(path: str | Path, template: str, title: str, facts: Mapping[str, Any]) -> int:
    """Fill in the template and write it to path; returns its size in bytes.

    facts: what the template names. Nothing in them becomes markup.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,  # every id, label and note is text
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {name: getattr(words, name) for name in FILTERS}
    html = environment.get_template(template).render(
        facts,
        title=title,
        date=datetime.date.today(),
        version=__version__,
        themes=themes(),
    )
    with whole(path) as temporary:
        temporary.write_text(html, encoding="utf-8")
    return len(html.encode())

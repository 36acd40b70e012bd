"""The card of a data set: a README of Markdown that people and the Hugging Face hub read."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2
import yaml

from mimeline import __version__
from mimeline.errors import printable
from mimeline.exchange.release import Release
from mimeline.reporting import words

TEMPLATES = Path(__file__).parent / "templates"
_WORDS = ("spaced", "percent", "count", "clips", "number", "minutes", "listing")


def write(
    path: Path, template: str, release: Release, front: Mapping[str, Any] | None = None, **facts
) -> None:
    """Fill in the template and write it. front: the YAML that stands before it, if any."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        undefined=jinja2.StrictUndefined,
        finalize=_plain,  # every name and text that is told is text
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {name: getattr(words, name) for name in _WORDS}
    environment.filters["code"] = lambda names: [f"`{name}`" for name in names]
    text = environment.get_template(template).render(
        facts, release=release, run=release.run, contents=release.contents, version=__version__
    )
    text = re.sub(r"\n{3,}", "\n\n", text).rstrip() + "\n"
    if front is not None:
        dumped = yaml.safe_dump(dict(front), sort_keys=False, allow_unicode=True, width=100)
        text = f"---\n{dumped}---\n\n{text}"
    path.write_text(text, encoding="utf-8")


def _plain(value: object) -> object:
    """A text on one line, without what Markdown or a browser would take for markup."""
    if not isinstance(value, str):
        return value
    text = printable(" ".join(value.split()))
    for character, written in (("&", "&amp;"), ("<", "&lt;"), ("|", "\\|")):
        text = text.replace(character, written)
    return text

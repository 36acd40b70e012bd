"""What a person wrote into a label file beside its answers: comments."""

from pathlib import Path

import yaml

from mimeline.atomic import whole


def opening(text: str) -> str:
    """The comments at the file's top, empty where there is none."""
    lines = text.splitlines()
    end = next((n for n, line in enumerate(lines) if line and not line.startswith("#")), len(lines))
    return "".join(f"{line}\n" for line in lines[:end]) if any(lines[:end]) else ""


def has_comments(text: str) -> bool:
    """Whether YAML holds comments. Raises yaml.YAMLError where it is none."""
    if "#" not in text:
        return False
    rest, done = "", 0
    for token in yaml.scan(text):
        if isinstance(token, yaml.ScalarToken):  # which may have the sign within
            rest += text[done : token.start_mark.index]
            done = token.end_mark.index
    return "#" in rest + text[done:]


def keep(copy: Path, text: str) -> None:
    """Write a copy, whole or not at all."""
    with whole(copy) as temporary:
        temporary.write_text(text, encoding="utf-8")

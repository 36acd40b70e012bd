"""YAML of text alone: lists, mappings, strings and null; no types, tags, anchors or second keys.

What a person writes stays as written: a clip may be called 007, 1e3 or no.
"""

import re
from pathlib import Path

import yaml
from yaml.composer import Composer
from yaml.constructor import ConstructorError, SafeConstructor
from yaml.parser import Parser
from yaml.reader import Reader, ReaderError
from yaml.resolver import BaseResolver
from yaml.scanner import Scanner

from mimeline.errors import BadLabels

MOST_BYTES = 2**20
DEEPEST = 8
NULL = "tag:yaml.org,2002:null"
_CONFLICT = ("<<<<<<<", ">>>>>>>", "=======")


def read_yaml(path: str | Path) -> dict | list | str | None:
    """What the file holds. Raises BadLabels where it is none, too large or not to be trusted."""
    text = _text(path)
    try:
        loader = _Loader(text)
        try:
            return loader.get_single_data()
        finally:
            loader.dispose()
    except yaml.YAMLError as error:
        conflict = [
            n for n, line in enumerate(text.split("\n"), start=1) if line.startswith(_CONFLICT)
        ]
        line = conflict[0] if conflict else _line(error, text)
        raise BadLabels(
            path,
            place=f"line {line}" if line else "",
            found="marks of a conflict in git" if conflict else _problem(error),
            expected="YAML",
            remedy="Keep a line per cluster of those between the marks, and remove the marks."
            if conflict
            else "Mend the file's syntax.",
        ) from error


def _text(path: str | Path) -> str:
    remedy = "Run mimeline label, or set label.file to null."
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        found = "no such file" if missing else str(error.strerror or error)
        raise BadLabels(path, found=found, expected="a label file", remedy=remedy) from error
    except ValueError as error:  # a null character in the path
        raise BadLabels(path, found=str(error), expected="a label file", remedy=remedy) from error
    if len(content) > MOST_BYTES:
        raise BadLabels(
            path,
            found=f"more than {MOST_BYTES:,} bytes",
            expected="a label file",
            remedy="Correct label.file.",
        )
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise BadLabels(
            path,
            place=f"line {content[: error.start].count(10) + 1}",
            found=f"the byte 0x{content[error.start]:02x}",
            expected="YAML in UTF-8",
            remedy="Save the file as UTF-8.",
        ) from error


def _line(error: yaml.YAMLError, text: str) -> int | None:
    if isinstance(error, ReaderError):
        return text.count("\n", 0, error.position) + 1
    mark = getattr(error, "problem_mark", None)
    return mark.line + 1 if mark else None


def _problem(error: yaml.YAMLError) -> str:
    if isinstance(error, ReaderError):
        return f"the character U+{error.character:04X}"
    return getattr(error, "problem", None) or str(error)


class _Loader(Reader, Scanner, Parser, Composer, SafeConstructor, BaseResolver):
    def __init__(self, text: str):
        Reader.__init__(self, text)
        Scanner.__init__(self)
        Parser.__init__(self)
        Composer.__init__(self)
        SafeConstructor.__init__(self)
        BaseResolver.__init__(self)
        self._depth = 0

    def compose_node(self, parent, index):
        event = self.peek_event()
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            raise _refused("an anchor or alias", event)
        if event.tag is not None:
            raise _refused(f"the tag {event.tag}", event)
        if self._depth == DEEPEST:
            raise _refused("lists or mappings nested too deep", event)
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _refused("a key that is no text", key)
            if key.value in seen:
                raise _refused(f"the key {key.value} a second time", key)
            seen.add(key.value)
        return {key.value: self.construct_object(value, deep=True) for key, value in node.value}

    def flatten_mapping(self, node):
        """No keys are merged: `<<` is a key as any."""


_Loader.add_implicit_resolver(NULL, re.compile(r"(?:~|null|Null|NULL|)$"), ["~", "n", "N", ""])


def _refused(problem: str, at) -> ConstructorError:
    return ConstructorError(None, None, problem, at.start_mark)


class Writer(yaml.SafeDumper):
    """Text that could break a line or steer a terminal is written in escapes."""


def _text_node(writer: Writer, text: str) -> yaml.ScalarNode:
    style = None if text.isprintable() else '"'
    return writer.represent_scalar("tag:yaml.org,2002:str", text, style=style)


Writer.add_representer(str, _text_node)

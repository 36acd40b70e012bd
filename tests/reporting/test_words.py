"""Every rule that a stage can write to its ledger is told in words."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import mimeline
from mimeline.reporting import words

SOURCE = Path(mimeline.__file__).parent
ROOMS = ("clips", "dataset", "media", "tracking")
SAYING = ("drop", "fail", "note", "Finding")  # given a rule as the first or second argument


def rules(tree: ast.AST) -> Iterator[str]:
    """The rules that a module names, as an argument, an attribute, a key or before its facts."""
    for node in ast.walk(tree):
        match node:
            case ast.keyword(arg="rule", value=value):
                yield from _texts(value)
            case ast.Assign(targets=[ast.Name("rule")], value=value):
                yield from _texts(value)
            case ast.Dict(keys=keys, values=values):
                for key, value in zip(keys, values, strict=True):
                    if isinstance(key, ast.Constant) and key.value == "rule":
                        yield from _texts(value)
            case ast.Tuple([ast.Constant(str(rule)), ast.Dict() | ast.BinOp() | ast.Name("facts")]):
                yield rule
            case ast.Call(func=ast.Name(name) | ast.Attribute(attr=name), args=given):
                if name in SAYING:
                    for value in given[:2]:
                        yield from _texts(value)


def _texts(value: ast.expr) -> Iterator[str]:
    """The constants that an expression may become."""
    match value:
        case ast.Constant(str(text)) if text and text not in SAYING:
            yield text
        case ast.IfExp(body=body, orelse=other):
            yield from _texts(body)
            yield from _texts(other)


MODULES = sorted(path for room in ROOMS for path in (SOURCE / room).rglob("*.py"))
WRITTEN = {
    rule: str(path.relative_to(SOURCE))
    for path in MODULES
    for rule in rules(ast.parse(path.read_text(encoding="utf-8")))
}


@pytest.mark.parametrize("rule", WRITTEN)
def test_a_rule_that_the_code_can_write_is_told_in_words(rule):
    assert rule in words.RULES, WRITTEN[rule]


def test_the_rules_are_found_however_they_are_written():
    assert words.RULES.keys() == WRITTEN.keys()

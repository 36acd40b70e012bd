"""Values from a user, checked: complete and of their types, or one line for each mistake."""

from typing import Any

import yaml
from pydantic import ValidationError

from mimeline.config.sections import Config
from mimeline.errors import BadConfig


def validate(values: dict[str, Any], file: str = "config") -> dict[str, Any]:
    """The configuration, checked and complete: every key present, text numbers made numbers.

    Raises an ExceptionGroup of BadConfig, one for each mistake.
    """
    try:
        return Config.model_validate(values).model_dump(mode="json")
    except ValidationError as error:
        problems = [_problem(problem, file) for problem in error.errors(include_url=False)]
        raise ExceptionGroup("the configuration cannot be used", problems) from None


def checked(values: dict[str, Any], file: str = "config") -> dict[str, Any]:
    """What `validate` gives. Raises the first mistake alone, a BadConfig."""
    try:
        return validate(values, file)
    except ExceptionGroup as group:
        raise group.exceptions[0] from None


def _problem(problem: dict[str, Any], file: str) -> BadConfig:
    key = ".".join(str(part) for part in problem["loc"])
    found = "an unknown key" if problem["type"] == "extra_forbidden" else repr(problem["input"])
    return BadConfig(
        file,
        place=f"key {key}" if key else "",
        found=found if key else "values that do not agree",
        expected=_expected(problem, key),
        remedy="config/README.md explains every key.",
    )


def _expected(problem: dict[str, Any], key: str) -> str:
    if problem["type"] == "string_pattern_mismatch" and key.endswith("fps"):
        return "a rate like 30 or 30000/1001"
    if problem["type"] == "model_type":
        return "keys and values"
    if problem["type"] == "too_short":
        return "at least one value"
    if problem["type"] != "extra_forbidden":
        return problem["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    section: Any = Config
    for part in key.split(".")[:-1]:
        section = section.model_fields[part].annotation
    return f"one of {', '.join(section.model_fields)}"


def value_of(text: str) -> Any:
    """What a value on the command line means: as in YAML, else the text."""
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        return text

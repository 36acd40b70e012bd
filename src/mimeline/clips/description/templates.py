"""The wording of descriptions: texts with named slots, read from YAML and never evaluated."""

import re
from pathlib import Path
from typing import Annotated, Literal

import yaml
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from mimeline.errors import BadFile, unreadable
from mimeline.vocabulary import resource

SLOT = re.compile(r"\{([^{}]*)\}")
PLAINLY = {  # pydantic's kind of error → what was expected
    "too_short": "{min_length} entries or more",
    "too_long": "{max_length} entries at most",
    "missing": "this key",
    "string_type": "a text",
    "list_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "float_type": "a number",
    "float_parsing": "a number",
}
REMEDY = "docs/descriptions.md has every key and slot."


def _with_slots(*allowed: str):
    """The type of a text that may hold these slots and no other brace."""

    def check(text: str) -> str:
        unknown = [slot for slot in SLOT.findall(text) if slot not in allowed]
        if unknown or "{" in SLOT.sub("", text) or "}" in SLOT.sub("", text):
            known = ", ".join("{" + slot + "}" for slot in allowed) or "none"
            raise ValueError(f"a text whose slots are among: {known}")
        if any(not character.isprintable() for character in text):
            raise ValueError("a text without control characters")
        return text

    return Annotated[str, AfterValidator(check)]


def _several(text):
    return Annotated[list[text], Field(min_length=1)]


def fill(text: str, **slots: str) -> str:
    """The text with its slots filled; a word put in is never looked at for slots again."""
    return SLOT.sub(lambda found: slots[found[1]], text)


PLAIN = _with_slots()
FORMS = Annotated[list[_with_slots("their")], Field(min_length=3, max_length=3)]
PLAIN_FORMS = Annotated[list[_with_slots("emotion")], Field(min_length=3, max_length=3)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, str_min_length=0)


class Subject(_Part):
    """Whom a clip shows. plural: whether the pronoun takes "talk" rather than "talks"."""

    noun: PLAIN
    they: PLAIN
    their: PLAIN
    plural: bool


class Subjects(_Part):
    female: Subject
    male: Subject
    unknown: Subject


class Openers(_Part):
    first: _several(PLAIN)
    next: _several(PLAIN)
    last: _several(PLAIN)
    late: _several(PLAIN)
    resumed: _several(PLAIN)


class Join(_Part):
    """What stands between actions; with `before_ing`, all but the first are in the -ing form."""

    model_config = ConfigDict(populate_by_name=True)

    between: PLAIN
    last: PLAIN
    before_ing: PLAIN | None = Field(None, alias="while")


class Duration(_Part):
    up_to: Annotated[float, Field(gt=0, le=1)]
    says: _several(PLAIN)


class Passing(_Part):
    brief: _several(_with_slots("verb"))
    once: _several(_with_slots("verb"))
    twice: _several(_with_slots("verb"))
    several: _several(_with_slots("verb"))


class Layout(_Part):
    between: PLAIN
    capitals: bool


class Appearance(_Part):
    adjectives: dict[str, PLAIN]
    features: dict[str, PLAIN]


class Action(_Part):
    """What is said of an action: [he does, they do, doing] each."""

    throughout: FORMS
    passing: FORMS | None = None  # null: as throughout
    brief: FORMS | None = None  # null: as passing, and "briefly"
    brief_s: float = Field(float("inf"), gt=0)

    @model_validator(mode="before")
    @classmethod
    def _forms_alone(cls, given):
        return {"throughout": given} if isinstance(given, list) else given


class Templates(_Part):
    subjects: Subjects
    mentions: _several(_with_slots("a", "noun"))
    again: _several(_with_slots("they", "noun"))
    openers: Openers
    joins: _several(Join)
    durations: _several(Duration)
    passing: Passing
    layouts: _several(Layout)
    emotions: dict[str, PLAIN]
    looks: PLAIN_FORMS
    degrees: dict[str, PLAIN]
    degreeless: list[str]
    appearance: Appearance
    actions: dict[str, Action]

    @model_validator(mode="after")
    def _durations_rise_to_one(self):
        shares = [duration.up_to for duration in self.durations]
        if shares != sorted(set(shares)) or shares[-1] != 1:
            raise ValueError("durations whose up_to rises, to 1 at last")
        return self


def read_templates(own: Path | None = None) -> Templates:
    """The product's wording, with what the user's own file says in its place.

    own: YAML; its mappings are merged into the product's, its lists replace them. Raises BadFile
    for what is no YAML, for unknown keys and slots, and for texts of the wrong form.
    """
    wording = _yaml(resource("descriptions.yaml"))
    if own is not None:
        wording = _merged(wording, _yaml(own))
    try:
        return Templates.model_validate(wording)
    except ValidationError as error:
        raise _explained(own or resource("descriptions.yaml"), error) from error


def _yaml(path: Path) -> dict:
    try:
        given = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise unreadable(path, error, expected="templates in YAML", remedy=REMEDY) from error
    if given is None:
        return {}
    if not isinstance(given, dict):
        raise BadFile(
            path, found=type(given).__name__, expected="a mapping of templates", remedy=REMEDY
        )
    return given


def _merged(under: dict, over: dict) -> dict:
    merged = dict(under)
    for key, value in over.items():
        both = isinstance(value, dict) and isinstance(under.get(key), dict)
        merged[key] = _merged(under[key], value) if both else value
    return merged


def _explained(path: Path, error: ValidationError) -> BadFile:
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"])
    expected: str = first["msg"].removeprefix("Value error, ")
    kind: Literal["extra_forbidden"] | str = first["type"]
    if kind == "extra_forbidden":
        place, key = ".".join(str(part) for part in first["loc"][:-1]), first["loc"][-1]
        return BadFile(
            path, place=place, found=f"the key {key}", expected="only known keys", remedy=REMEDY
        )
    found = repr(first["input"])[:100] if kind != "missing" else "nothing"
    if kind in PLAINLY:
        expected = PLAINLY[kind].format(**first.get("ctx", {}))
    expected = expected.removeprefix("Input should be ")
    return BadFile(path, place=place, found=found, expected=expected, remedy=REMEDY)

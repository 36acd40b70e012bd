"""What gestures are called, and which actions they are: `resources/directions.yaml`."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import yaml

from mimeline.vocabulary import ACTIONS, resource

WAYS = ("left", "right", "up", "down")
WAY = "{way}"
IRREGULAR = {
    "shook": "shake", "shaken": "shake", "thought": "think", "eyebrow": "brow", "eyebrows": "brow",
    "upward": "up", "upwards": "up", "downward": "down", "downwards": "down", "leftward": "left",
    "leftwards": "left", "rightward": "right", "rightwards": "right",
}  # fmt: skip
VOWELS = "aeiou"
KINDS = ("gestures", "feelings", "rests")  # sections of the resource


@dataclass(frozen=True)
class Gesture:
    """words: what it was called. steps: actions that follow each other, each step's together.
    seconds: of a step, None where any do. times: how often, where nobody says. side: the subject's,
    None: both. family: what a way that is said alone goes on with, "Gaze" or "Head"; goes_on: this
    is such a way. A rest has steps without actions."""

    words: str
    steps: tuple[tuple[str, ...], ...]
    seconds: Fraction | None
    side: str | None
    times: int = 1
    family: str | None = None
    goes_on: bool = False

    def excludes(self, other: "Gesture") -> bool:
        """Whether both cannot be done at once: they have actions of one track, and of one side."""
        tracks = [
            {ACTIONS[action].track for step in own.steps for action in step}
            for own in (self, other)
        ]
        apart = self.side and other.side and self.side != other.side
        return bool(tracks[0] & tracks[1]) and not apart

    def then(self, other: "Gesture") -> "Gesture":
        """Both as one, the other after this."""
        return replace(other, words=f"{self.words} {other.words}", steps=self.steps + other.steps)


def matched(words: Sequence[str], before: Gesture | None) -> tuple[list[Gesture], list[str]]:
    """The gestures that plain words say, and the words that say none.

    before: the gesture that was said last, which ways alone go on with: "look up and left".
    """
    found: list[Gesture] = []
    unknown: list[str] = []
    at = 0
    while at < len(words):
        rest = " ".join(words[at:])
        fits = [(match, known) for pattern, known in _PATTERNS if (match := pattern.match(rest))]
        if fits:
            match, known = max(fits, key=lambda fit: len(fit[0][0].split()))
            found.append(known.said(match))
            at += len(match[0].split())
        elif words[at] in WAYS and (last := found[-1] if found else before) and last.family:
            found.append(replace(_turned(last.family, [words[at]], words[at]), goes_on=True))
            at += 1
        else:
            unknown.append(words[at])
            at += 1
    return found, unknown


@dataclass(frozen=True)
class _Known:
    do: tuple[str, ...]
    seconds: Fraction | None
    side: str | None
    times: int
    together: bool  # a feeling or a rest: its actions, if any, go together

    def said(self, match: re.Match) -> Gesture:
        groups = match.groupdict()
        side = groups.get("side") or self.side
        if self.do and WAY in self.do[0]:
            ways = [groups["way"], *filter(None, [groups.get("way2")])]
            return _turned(self.do[0].removesuffix(WAY), ways, match[0])
        steps = (self.do,) if self.together else tuple((action,) for action in self.do)
        family = self.do[0].removesuffix("Up").removesuffix("Down") if len(self.do) == 1 else None
        family = family if family in ("Gaze", "Head") else None
        return Gesture(match[0], steps, self.seconds, side, self.times, family)


def _turned(family: str, ways: Sequence[str], words: str) -> Gesture:
    actions = tuple(dict.fromkeys(f"{family}{way.capitalize()}" for way in ways))
    return Gesture(words, (actions,), None, None, family=family)


def _pattern(text: str) -> re.Pattern:
    words = re.sub(r"\[([^]]+)\] ", r"(?:\1 )?", text)
    words = re.sub(r" \[([^]]+)\]", r"(?: \1)?", words)
    side = "(?:(?P<side>left|right) )?"
    words = words.replace("{side} ", side)
    way = "|".join(WAYS)
    words = words.replace(WAY, f"(?P<way>{way})(?: (?P<way2>{way}))?")
    return re.compile(rf"{words}(?!\S)")


def _forms(word: str) -> Iterator[str]:
    """How a plain word may stand in a sentence."""
    stem = word[:-1] if word.endswith("e") else word
    doubled = word + word[-1] if len(word) > 2 and word[-1] not in VOWELS + "wxy" else word
    yield from (word, f"{word}s", f"{word}es", f"{stem}ing", f"{stem}ed", f"{doubled}ing")
    yield from (f"{doubled}ed", f"{word}'s")


def _read() -> dict[str, Any]:
    return yaml.safe_load(resource("directions.yaml").read_text(encoding="utf-8"))


_TOLD = _read()
TIMING: dict[str, Fraction] = {name: Fraction(str(s)) for name, s in _TOLD["timing"].items()}
FILLERS: frozenset[str] = frozenset(_TOLD["fillers"].split()) | {
    form for verb in _TOLD["filler_verbs"].split() for form in _forms(verb)
}
UNSAYABLE: dict[str, str] = {
    word: own["because"] for own in _TOLD["unsayable"] for word in own["words"].split()
}
_PATTERNS: list[tuple[re.Pattern, _Known]] = [
    (
        _pattern(said),
        _Known(
            tuple(own["do"]),
            Fraction(str(own["seconds"])) if "seconds" in own else None,
            own.get("side"),
            own.get("times", 1),
            kind != "gestures",
        ),
    )
    for kind in KINDS
    for own in _TOLD[kind]
    for said in own["say"].split(", ")
]
_WORDS = {
    word
    for kind in KINDS
    for own in _TOLD[kind]
    for word in re.findall(r"(?<![{\w])[a-z]+(?![}\w])", own["say"])
}
PLAIN: dict[str, str] = (
    IRREGULAR
    | {form: word for word in sorted(_WORDS) for form in _forms(word)}
    | {word: word for word in _WORDS}
)

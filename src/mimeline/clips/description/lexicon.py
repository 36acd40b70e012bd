"""What is said of each action and emotion, in every form, for every kind of subject."""

import math
from collections.abc import Container, Iterable
from dataclasses import dataclass

from mimeline.clips.description.inflection import forms
from mimeline.clips.description.templates import Templates, fill
from mimeline.errors import printable

EMOTION = "emotion:"  # before an emotion's name, where it stands beside actions

Forms = tuple[str, str, str]  # he does, they do, doing


@dataclass(frozen=True)
class Said:
    """An action's forms for one kind of subject; n_words of the longest."""

    throughout: Forms
    passing: Forms
    brief: Forms | None
    brief_s: float
    n_words: int


class Lexicon:
    """Looks up an action's forms; one without a template is told by its name, and noted.

    rank: the order in which actions are told that begin together. untold: the names that had no
    template, with what was said instead.
    """

    def __init__(self, templates: Templates):
        self.templates = templates
        self.rank = {name: number for number, name in enumerate(templates.actions)}
        self.untold: dict[str, str] = {}
        self._said: dict[tuple[str, str], Said] = {}

    def said(self, name: str, subject: str) -> Said:
        """The forms of an action, or of an emotion as `emotion` names it."""
        key = (name, subject)
        if key not in self._said:
            self._said[key] = self._filled(name, subject)
        return self._said[key]

    def action(self, name: str) -> str:
        """The name under which an action has a template, as shake_head for "Shake head"."""
        return known_as(name, self.templates.actions)

    def emotion(self, name: str, degree: str = "") -> str:
        """The name of an emotion where it stands beside actions. degree: "very", or nothing."""
        known = known_as(name, self.templates.emotions)
        return f"{EMOTION}{'' if known in self.templates.degreeless else degree}:{known}"

    def _filled(self, name: str, subject: str) -> Said:
        if name not in self.templates.actions:
            bare = self._look(name) if name.startswith(EMOTION) else self._by_its_name(name)
            return Said(bare, bare, None, math.inf, _longest(bare))
        action = self.templates.actions[name]
        their = getattr(self.templates.subjects, subject).their
        throughout, passing, brief = (
            tuple(fill(form, their=their) for form in given) if given else None
            for given in (action.throughout, action.passing, action.brief)
        )
        n_words = _longest([*throughout, *(passing or ()), *(brief or ())])
        return Said(throughout, passing or throughout, brief, action.brief_s, n_words)

    def _look(self, name: str) -> Forms:
        degree, _, emotion = name.removeprefix(EMOTION).partition(":")
        word = self.templates.emotions.get(emotion)
        if word is None:
            word = self.untold[emotion] = " ".join(printable(emotion).replace("_", " ").split())
        look = " ".join(part for part in (degree, word) if part)
        return tuple(fill(form, emotion=look) for form in self.templates.looks)

    def _by_its_name(self, name: str) -> Forms:
        said = forms(name)
        self.untold[name] = said[0]
        return said


def known_as(name: str, known: Container[str]) -> str:
    """The name in the letters in which it is known, as shake_head; itself where it is not."""
    if name in known:
        return name
    folded = "_".join(name.lower().replace("-", " ").replace("_", " ").split())
    return folded if folded in known else name


def _longest(texts: Iterable[str]) -> int:
    return max(len(text.split()) for text in texts)

"""Whom a clip shows, from its attributes: only what is known."""

from collections.abc import Collection

from mimeline.clips.description.lexicon import known_as
from mimeline.clips.description.templates import Templates


def subject_of(attributes: Collection[str]) -> str:
    """female or male where the attributes say one of them, else unknown."""
    said = [name for name in ("female", "male") if name in attributes]
    return said[0] if len(said) == 1 else "unknown"


def degree_of(attributes: Collection[str], templates: Templates) -> str:
    """How strongly an emotion is shown ("very"), or nothing."""
    return next((templates.degrees[name] for name in attributes if name in templates.degrees), "")


def nouns(attributes: Collection[str], templates: Templates) -> list[str]:
    """What the first mention may call the person: the bare noun, then with two features at most.

    attributes: as the catalogue has them. What has no template is not told.
    """
    noun = getattr(templates.subjects, subject_of(attributes)).noun
    look = templates.appearance
    adjectives, features = (
        [known[name] for given in attributes if (name := known_as(given, known)) in known]
        for known in (look.adjectives, look.features)
    )
    turned = [*features[1:], *features[:1]]
    pairs = [list(dict.fromkeys(pair)) for pair in zip(features, turned, strict=True)] or [[]]
    fuller = []
    for number, pair in enumerate(pairs):
        adjective = [adjectives[number % len(adjectives)]] if adjectives else []
        fuller.append(" ".join([*adjective, noun, *(["with", " and ".join(pair)] if pair else [])]))
    return list(dict.fromkeys([noun, *fuller]))

"""English forms of an action's name that has no template of its own."""

import re

from mimeline.errors import printable

VOWELS = "aeiou"


def forms(name: str) -> tuple[str, str, str]:
    """(he does, they do, doing) of a name such as plays_guitar, play-guitar or PlayGuitar.

    Its first word is taken for the verb: in the form of "plays" where it ends in a single s.
    """
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])|[\s_-]+", " ", name)
    verb, *rest = printable(spaced).lower().split() or ["act"]
    if verb.endswith("s") and not verb.endswith(("ss", "us", "is")):
        verb = _base(verb)
    return tuple(" ".join([form, *rest]) for form in (_third(verb), verb, _ing(verb)))


def _base(third: str) -> str:
    if third.endswith("ies") and len(third) > 4:
        return third[:-3] + "y"
    if third.endswith(("ches", "shes", "sses", "xes", "zzes", "oes")):
        return third[:-2]
    return third[:-1]


def _third(verb: str) -> str:
    if verb.endswith("y") and verb[-2:-1] not in VOWELS:
        return verb[:-1] + "ies"
    return verb + ("es" if verb.endswith(("s", "sh", "ch", "x", "z", "o")) else "s")


def _ing(verb: str) -> str:
    if verb.endswith("ie"):
        return verb[:-2] + "ying"
    if verb.endswith("e") and not verb.endswith(("ee", "oe", "ye")):
        return verb[:-1] + "ing"
    if re.fullmatch(rf"[^{VOWELS}]+[{VOWELS}][^{VOWELS}wxy]", verb):
        return verb + verb[-1] + "ing"
    return verb + "ing"

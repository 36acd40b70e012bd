"""When something happens, as people say it: `from 1 s to 2 s`, `for half a second`."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import count

NUMBERS = {
    **{
        word: Fraction(n)
        for n, word in enumerate(["zero", "one", "two", "three", "four", "five", "six"])
    },
    **{word: Fraction(n) for n, word in enumerate(["seven", "eight", "nine", "ten"], 7)},
    **dict.fromkeys(("half a", "half an", "a half", "half"), Fraction(1, 2)),
    **dict.fromkeys(("one and a half", "1 and a half"), Fraction(3, 2)),
    **dict.fromkeys(("a couple of", "a couple"), Fraction(2)),
    **dict.fromkeys(("a", "an"), Fraction(1)),
    "a quarter of a": Fraction(1, 4),
    "a few": Fraction(3),
}
BRIEF, LONG, SEVERAL = Fraction(3, 5), Fraction(3), 3  # seconds, seconds, times

NUMBER = rf"\d+(?:\.\d+)?|{'|'.join(sorted(NUMBERS, key=len, reverse=True))}"
UNIT = r"milliseconds?|ms|seconds?|secs?|s|frames?|f"


@dataclass(frozen=True)
class When:
    """What is said of time, in seconds from the clip's start; None: nothing.

    last: seconds before the clip's end at which it begins. until_end: it ends as the clip does.
    times: how often it happens.
    """

    start: Fraction | None = None
    end: Fraction | None = None
    lasts: Fraction | None = None
    last: Fraction | None = None
    until_end: bool = False
    times: int | None = None

    def joined(self, other: "When") -> "When | None":
        """What both say together; None where they say different things of the same."""
        said = {}
        for name in self.__dataclass_fields__:
            a, b = getattr(self, name), getattr(other, name)
            if a and b and a != b:
                return None
            said[name] = a if a is not None and a is not False else b
        return When(**said)


def taken(text: str, fps: Fraction) -> tuple[str, dict[str, When]]:
    """Text without what it says of time, each phrase replaced by a mark (@0, @1, ...), and what
    each says.

    text: words and numbers in lower case, a blank between them. fps: what a second has of frames.
    """
    found: dict[str, When] = {}
    numbers = count()
    for pattern, meaning in PHRASES:

        def mark(match: re.Match, meaning: Callable = meaning) -> str:
            said = meaning(match, fps)
            if said is None:
                return match[0]
            found[name := f"@{next(numbers)}"] = said
            return name

        text = pattern.sub(mark, text)
    return text, found


def _phrases() -> Iterator[tuple[re.Pattern, Callable[[re.Match, Fraction], When | None]]]:
    def phrase(text: str, meaning: Callable[[re.Match, Fraction], When | None]):
        return re.compile(rf"(?<![\w@]){text}(?![\w@])"), meaning

    lead = r"(?:(?P<lead>from|between|during|in|over|starting at|beginning at) )?(?:the )?"
    unit = r"(?:(?P<{0}>seconds?|frames?) )?"
    yield phrase(
        rf"{lead}{unit.format('u0')}(?P<a>{NUMBER})(?: ?(?P<ua>{UNIT}))? (?:to|until|till|and|-) "
        rf"(?:the )?{unit.format('u1')}(?P<b>{NUMBER})(?: ?(?P<ub>{UNIT}))?",
        _range,
    )
    few = rf"(?:(?P<a>{NUMBER}) )?(?P<ua>{UNIT})"
    yield phrase(rf"(?:for|in|during|within) the first {few}", _first)
    yield phrase(rf"(?:for|in|during|within) the last {few}", _last)
    one = rf"{unit.format('u0')}(?P<a>{NUMBER})(?: ?(?P<ua>{UNIT}))?"
    yield phrase(rf"(?:for|lasting)(?: about| around)? (?P<a>{NUMBER}) ?(?P<ua>{UNIT})", _lasts)
    yield phrase(rf"(?:until|till|up to|ending at) {one}", _end)
    start = (
        rf"(?:at|after|from|starting at|starting from|beginning at) {one}(?: later| on| onwards?)?"
    )
    yield phrase(start, _start)
    yield phrase(r"(?:until|till|to) the (?:very )?end", lambda m, f: When(until_end=True))
    yield phrase(r"at the (?:very )?end", lambda m, f: When(until_end=True))
    yield phrase(
        r"(?:throughout|all the time|(?:for |during )?the (?:whole|entire) (?:time|clip|while))"
        r"(?: the clip)?",
        lambda m, f: When(start=Fraction(0), until_end=True),
    )
    first = r"(?:at|from|in) the (?:very )?(?:beginning|start)|immediately|right away"
    yield phrase(f"(?:{first})", lambda m, f: When(start=Fraction(0)))
    moment = r"(?:for )?an? (?:brief |short )?(?:moment|instant)|briefly|quickly"
    yield phrase(f"(?:{moment})", lambda m, f: When(lasts=BRIEF))
    yield phrase(r"(?:slowly|for a (?:long )?(?:while|time))", lambda m, f: When(lasts=LONG))
    yield phrase(r"(?:twice|two times)", lambda m, f: When(times=2))
    yield phrase(r"(?:repeatedly|several times|a few times)", lambda m, f: When(times=SEVERAL))
    yield phrase(rf"(?P<a>{NUMBER}) times", lambda m, f: When(times=int(_number(m["a"]))))


def _range(match: re.Match, fps: Fraction) -> When | None:
    before, after = match["u0"] or match["ua"], match["u1"] or match["ub"]
    if not (before or after or match["lead"]):
        return None
    unit_a, unit_b = before or after or "s", after or before or "s"
    return When(start=_seconds(match["a"], unit_a, fps), end=_seconds(match["b"], unit_b, fps))


def _first(match: re.Match, fps: Fraction) -> When:
    return When(start=Fraction(0), end=_seconds(match["a"] or "one", match["ua"], fps))


def _last(match: re.Match, fps: Fraction) -> When:
    return When(last=_seconds(match["a"] or "one", match["ua"], fps), until_end=True)


def _lasts(match: re.Match, fps: Fraction) -> When:
    return When(lasts=_seconds(match["a"], match["ua"], fps))


def _end(match: re.Match, fps: Fraction) -> When | None:
    unit = match["u0"] or match["ua"]
    return None if _wordy(match["a"], unit) else When(end=_seconds(match["a"], unit or "s", fps))


def _start(match: re.Match, fps: Fraction) -> When | None:
    unit = match["u0"] or match["ua"]
    return None if _wordy(match["a"], unit) else When(start=_seconds(match["a"], unit or "s", fps))


def _wordy(number: str, unit: str | None) -> bool:
    """Whether a word that is a number only with a unit stands without: `at a`."""
    return unit is None and not number[0].isdigit()


def _seconds(number: str, unit: str, fps: Fraction) -> Fraction:
    value = _number(number)
    if unit.startswith("f"):
        return value / fps
    return value / 1000 if unit.startswith("m") else value


def _number(text: str) -> Fraction:
    return NUMBERS[text] if text in NUMBERS else Fraction(text)


PHRASES = tuple(_phrases())

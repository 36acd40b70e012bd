"""When something happens, as people say it: `from 1 s to 2 s`, `for half a second`."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
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
MOST_SECONDS = 600  # of a clip that is asked for in words
MOST_TIMES = 50  # that a gesture is done

NUMBER = rf"\d+(?:\.\d+)?|{'|'.join(sorted(NUMBERS, key=len, reverse=True))}"
UNIT = r"milliseconds?|ms|seconds?|secs?|s|frames?|f"


@dataclass(frozen=True)
class When:
    """What is said of time, in seconds from the clip's start; None: nothing.

    last: seconds before the clip's end at which it begins. until_end: it ends as the clip does.
    manner: how long it lasts by how it is done, where nobody says how long. times: how often it
    happens. Both are an action's own; what else is said, those that go with it share.
    """

    start: Fraction | None = None
    end: Fraction | None = None
    lasts: Fraction | None = None
    last: Fraction | None = None
    until_end: bool = False
    manner: Fraction | None = None
    times: int | None = None

    @property
    def shared(self) -> "When":
        return replace(self, manner=None, times=None)

    @property
    def contradicts(self) -> bool:
        """Whether start, end and length are all said, and are not of one span."""
        if self.lasts is None or self.start is None or self.end is None:
            return False
        return self.end - self.start != self.lasts

    @property
    def open(self) -> bool:
        """Whether nothing says when it ends."""
        return not (self.end or self.lasts or self.last or self.until_end or self.manner)

    def beside(self, shared: "When") -> "When":
        """What is said of an action and, where that is nothing, of what goes with it; one of which
        only its length is said begins as that does."""
        if self.shared == When():
            return replace(shared, manner=self.manner, times=self.times)
        if self.shared == When(lasts=self.lasts):
            return replace(self, start=shared.start)
        return self

    def joined(self, other: "When") -> "When | None":
        """What both say together; None where they say different things of the same."""
        said = {}
        for name in self.__dataclass_fields__:
            a, b = getattr(self, name), getattr(other, name)
            if a == b or b is None or b is False:
                said[name] = a
            elif a is None or a is False:
                said[name] = b
            else:
                return None
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
        return re.compile(rf"(?<![\w@.]){text}(?![\w@])"), meaning

    lead = r"(?:(?P<lead>from|between|during|in|over|starting at|beginning at) )?(?:the )?"
    edge = rf"(?:(?P<u{{0}}>seconds?|frames?) )?(?P<{{0}}>{NUMBER})(?: (?P<{{0}}u>{UNIT}))?"
    one = edge.format("a")
    joint = r"(?P<joint>to|until|till|and|-) (?:the )?"
    yield phrase(rf"{lead}{one} {joint}{edge.format('b')}", _range)
    few = rf"(?:(?P<a>{NUMBER}) )?(?P<au>{UNIT})"
    yield phrase(rf"(?:for|in|during|within) the first {few}", _first)
    yield phrase(rf"(?:for|in|during|within) the last {few}", _last)
    yield phrase(rf"(?:for|over|lasting)(?: about| around)? (?P<a>{NUMBER}) (?P<au>{UNIT})", _lasts)
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
    moment = r"(?:for )?an? (?:brief |short )?(?:moment|instant)|briefly|quickly|brief|quick|short"
    yield phrase(f"(?:{moment})", lambda m, f: When(manner=BRIEF))
    yield phrase(r"(?:slowly|slow|for a (?:long )?(?:while|time))", lambda m, f: When(manner=LONG))
    yield phrase(r"(?:twice|two times)", lambda m, f: When(times=2))
    yield phrase(r"(?:repeatedly|several times|a few times)", lambda m, f: When(times=SEVERAL))
    yield phrase(rf"(?P<a>{NUMBER}) times", _times)
    alone = "".join(rf"(?<!{w} )" for w in ("in", "within", "by", "every", "each", "and", ","))
    yield phrase(rf"{alone}(?!an? (?:{UNIT})\b)(?P<a>{NUMBER}) (?P<au>{UNIT})", _lasts)


def _range(match: re.Match, fps: Fraction) -> When | None:
    units = [_unit(match, "a"), _unit(match, "b")]
    joint_fits = match["joint"] != "and" or match["lead"] == "between"
    if not joint_fits or not (any(units) or match["lead"]):
        return None
    if match.string[: match.start()].endswith("for "):  # 2 to 3 seconds long
        return None
    first, second = units[0] or units[1] or "s", units[1] or units[0] or "s"
    return When(start=_seconds(match["a"], first, fps), end=_seconds(match["b"], second, fps))


def _first(match: re.Match, fps: Fraction) -> When:
    return When(start=Fraction(0), end=_seconds(match["a"] or "one", match["au"], fps))


def _last(match: re.Match, fps: Fraction) -> When:
    return When(last=_seconds(match["a"] or "one", match["au"], fps), until_end=True)


def _lasts(match: re.Match, fps: Fraction) -> When:
    return When(lasts=_seconds(match["a"], match["au"], fps))


def _end(match: re.Match, fps: Fraction) -> When | None:
    moment = _moment(match, fps)
    return None if moment is None else When(end=moment)


def _start(match: re.Match, fps: Fraction) -> When | None:
    moment = _moment(match, fps)
    return None if moment is None else When(start=moment)


def _times(match: re.Match, fps: Fraction) -> When | None:
    times = _number(match["a"])
    return When(times=int(times)) if times.denominator == 1 and 0 < times <= MOST_TIMES else None


def _moment(match: re.Match, fps: Fraction) -> Fraction | None:
    """In seconds; None for a word that is a number only with a unit and stands without: `at a`."""
    unit = _unit(match, "a")
    wordy = unit is None and not match["a"][0].isdigit()
    return None if wordy else _seconds(match["a"], unit or "s", fps)


def _unit(match: re.Match, number: str) -> str | None:
    """What stands before the number (frame 10) or after it (10 frames)."""
    return match[f"u{number}"] or match[f"{number}u"]


def _seconds(number: str, unit: str, fps: Fraction) -> Fraction:
    value = _number(number)
    if unit.startswith("f"):
        return value / fps
    return value / 1000 if unit.startswith("m") else value


def _number(text: str) -> Fraction:
    return NUMBERS[text] if text in NUMBERS else Fraction(text)


PHRASES = tuple(_phrases())

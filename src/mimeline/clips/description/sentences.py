"""Stretches → texts: who is seen, what they do at the same time, for how long, what comes next."""

import hashlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import cycle, islice, pairwise

from mimeline.clips.description.lexicon import EMOTION, Forms, Lexicon, Said
from mimeline.clips.description.stretches import SAME_S, Run, Stretch, around_passing
from mimeline.clips.description.templates import Join, fill

THIRD, PLURAL, ING = range(3)
VOWELS = "aeiou"


@dataclass(frozen=True)
class Scene:
    """What a text tells of a clip.

    subject: female, male or unknown. nouns: what the person may be called, without article, the
    plainest first. untimed: what is seen at some time that nobody says. min_s: what is shorter
    happens briefly.
    """

    subject: str
    nouns: Sequence[str]
    untimed: Sequence[str]
    stretches: Sequence[Stretch]
    duration_s: float
    min_s: float


def texts_of(scene: Scene, lexicon: Lexicon, number: int, key: str) -> list[str]:
    """At most number different texts of the scene: the plain one, then others in key's order.

    The same key gives the same texts, whatever other clips there are.
    """
    teller = _Teller(scene, lexicon)
    found: dict[str, None] = {}
    for choice in _orderly(teller.sizes, key):
        found[teller.text(choice)] = None
        if len(found) == number:
            break
    return list(found)


def _orderly(sizes: dict[str, int], key: str) -> Iterator[dict[str, int]]:
    """All choices of one of each kind, the first of every kind first, then as the key has it."""
    total = math.prod(sizes.values())
    digest = hashlib.blake2b(key.encode(errors="surrogatepass"), digest_size=16).digest()
    start = int.from_bytes(digest[:8], "little") % total
    step = int.from_bytes(digest[8:], "little") % total
    while math.gcd(step, total) != 1:
        step += 1
    numbers = ((start + turn * step) % total for turn in range(total))
    yield dict.fromkeys(sizes, 0)
    for number in numbers:
        choice = {}
        for kind, size in sizes.items():
            number, choice[kind] = divmod(number, size)
        yield choice


class _Teller:
    """Tells one scene in the wordings that a choice picks."""

    def __init__(self, scene: Scene, lexicon: Lexicon):
        self.scene = scene
        self.templates = lexicon.templates
        self.said = partial(lexicon.said, subject=scene.subject)
        self.subject = getattr(self.templates.subjects, scene.subject)
        self.parts, self.lasting = _without_lasting_emotions(scene)
        self.late = bool(self.parts) and self.parts[0].start_s > SAME_S
        self.n_clauses = len(self.parts) + bool(self.lasting) + bool(scene.untimed)
        self.sizes = self._sizes()

    def _sizes(self) -> dict[str, int]:
        """How many wordings there are of each kind; one where a kind does not occur."""
        templates, parts = self.templates, self.parts
        openers = templates.openers
        several = any(len(part.throughout) > 1 for part in parts)
        timed = self.lasting or any(part.throughout for part in parts)
        longest = max(len(duration.says) for duration in templates.durations)
        rarest = max(len(says) for _, says in templates.passing)
        kinds = {
            "mention": len(templates.mentions),
            "noun": len(self.scene.nouns),
            "join": len(templates.joins) if several else 1,
            "order": 2 if several else 1,
            "duration": longest if timed else 1,
            "passing": rarest if any(part.passing for part in parts) else 1,
        }
        if self.n_clauses > 1:
            kinds["again"] = len(templates.again)
        if self.late or len(parts) > 1:
            kinds["first"] = len(openers.late if self.late else openers.first)
        if len(parts) > 1:
            kinds["layout"] = len(templates.layouts)
            kinds["next"] = math.lcm(len(openers.next), len(openers.resumed))
        if len(parts) > 2:
            kinds["last"] = len(openers.last)
        return kinds

    def text(self, choice: dict[str, int]) -> str:
        mentions = self._mentions(choice)
        heads, told = [], []
        for body in self._heads(choice):
            who, form = next(mentions)
            heads.append(f"{who} {body(form)}")
        for opener, part in zip(self._openers(choice), self.parts, strict=True):
            who, form = next(mentions)
            told.append(f"{opener}{who} {self._body(part, form, choice)}")
        layout = self.templates.layouts[choice.get("layout", 0)]
        joined = layout.between.join(map(_capital, told) if layout.capitals else told)
        sentences = [*heads, *([joined] if joined else [])]
        return ". ".join(map(_capital, sentences)) + "."

    def _mentions(self, choice: dict[str, int]) -> Iterator[tuple[str, int]]:
        """What the person is called each time, and the form that verbs take after it."""
        noun, again = self.scene.nouns[choice["noun"]], self.templates.again[choice.get("again", 0)]
        article = "an" if noun[:1] in VOWELS else "a"
        yield fill(self.templates.mentions[choice["mention"]], noun=noun, a=article), THIRD
        plural = self.subject.plural and "{they}" in again
        named = fill(again, they=self.subject.they, noun=self.subject.noun)
        while True:
            yield named, PLURAL if plural else THIRD

    def _heads(self, choice: dict[str, int]) -> list[Callable[[int], str]]:
        """What stands before the stretches, by the form of its verbs."""
        join = self.templates.joins[0]
        untimed = [self.said(name).passing for name in self.scene.untimed]
        lasting = [self.said(name).throughout for name in self.lasting]
        heads = []
        if untimed:
            heads.append(lambda form: _joined([said[form] for said in untimed], join))
        if lasting:
            how_long = self._duration(1.0, choice)
            heads.append(
                lambda form: f"{_joined([said[form] for said in lasting], join)} {how_long}"
            )
        return heads

    def _openers(self, choice: dict[str, int]) -> Iterator[str]:
        """What stands before each stretch; several in one text take turns."""
        openers, parts = self.templates.openers, self.parts
        nexts = _in_turn(openers.next, choice.get("next", 0))
        resumed = _in_turn(openers.resumed, choice.get("next", 0))
        if self.late or len(parts) > 1:
            yield (openers.late if self.late else openers.first)[choice["first"]] + " "
        elif parts:
            yield ""
        for before, part in pairwise(parts):
            to_the_end = part.end_s >= self.scene.duration_s - SAME_S
            if part.start_s - before.end_s > SAME_S:
                yield next(resumed) + " "
            elif part is parts[-1] and to_the_end and len(parts) > 2:
                yield openers.last[choice["last"]] + " "
            else:
                yield next(nexts) + " "

    def _body(self, part: Stretch, form: int, choice: dict[str, int]) -> str:
        if not part.throughout:
            return self._passing(part, form, choice)
        names = part.throughout[::-1] if choice["order"] else part.throughout
        said = [self.said(name).throughout for name in names]
        text = _at_once(said, form, self.templates.joins[choice["join"]])
        text += " " + self._duration((part.end_s - part.start_s) / self.scene.duration_s, choice)
        if part.passing:
            text += ", " + self._passing(part, ING, choice)
        return text

    def _duration(self, share: float, choice: dict[str, int]) -> str:
        durations = self.templates.durations
        says = next((d.says for d in durations if share <= d.up_to), durations[-1].says)
        return says[choice["duration"] % len(says)]

    def _passing(self, part: Stretch, form: int, choice: dict[str, int]) -> str:
        beside = form == ING  # what lasts
        before_s = -math.inf if beside else part.start_s - self.scene.min_s
        going_on = {run.name for run in part.passing if run.start_s <= before_s}
        verbs: dict[str, list[Run]] = {}
        for run in part.passing:
            said = self.said(run.name)
            forms = said.throughout if run.name in going_on else _in_passing(said, run)
            verbs.setdefault(forms[form], []).append(run)
        verb = _joined(list(verbs), self.templates.joins[0])
        says = self.templates.passing.several if beside else ()
        if len(verbs) == 1:
            says = self._how_often(verbs[verb], beside)
        return fill(says[choice["passing"] % len(says)], verb=verb) if says else verb

    def _how_often(self, happened: list[Run], beside: bool) -> Sequence[str]:
        """The wordings of one action in passing; none where its verb says enough.

        beside: whether it is told beside what lasts.
        """
        says, run = self.templates.passing, happened[0]
        brief = all(map(self._is_brief, happened))
        if len(happened) > 1:
            return says.twice if brief and len(happened) == 2 else says.several
        if _in_passing(said := self.said(run.name), run) is said.brief:
            return ()
        return says.brief if brief else says.once if beside else ()

    def _is_brief(self, run: Run) -> bool:
        return run.seconds < self.scene.min_s and run.uncertainty_s < self.scene.min_s


def _in_passing(said: Said, run: Run) -> Forms:
    return said.brief if said.brief and run.seconds < said.brief_s else said.passing


def _without_lasting_emotions(scene: Scene) -> tuple[list[Stretch], list[str]]:
    """The stretches without the emotions that last all the clip, and these.

    Where there is one stretch, its emotion stays in it.
    """
    parts = list(scene.stretches)
    edges = [
        0.0,
        *(edge for part in parts for edge in (part.start_s, part.end_s)),
        scene.duration_s,
    ]
    gapless = all(
        after - before <= SAME_S for before, after in zip(edges[::2], edges[1::2], strict=True)
    )
    if len(parts) < 2 or not gapless:
        return parts, []
    lasting = [
        name
        for name in parts[0].throughout
        if name.startswith(EMOTION) and all(name in part.throughout for part in parts)
    ]
    rest = [
        part._replace(throughout=tuple(n for n in part.throughout if n not in lasting))
        for part in parts
    ]
    told = [part for part in rest if part.throughout or part.passing]
    return [around_passing(part, scene.min_s) for part in told], lasting


def _at_once(said: Sequence[Forms], form: int, join: Join) -> str:
    if join.before_ing is None or len(said) == 1:
        return _joined([forms[form] for forms in said], join)
    first, *others = said
    return first[form] + join.before_ing + _joined([forms[ING] for forms in others], join)


def _joined(words: Sequence[str], join: Join) -> str:
    return join.last.join([*([join.between.join(words[:-1])] if words[:-1] else []), words[-1]])


def _in_turn(says: Sequence[str], first: int) -> Iterator[str]:
    return islice(cycle(says), first % len(says), None)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]

"""What a person answered about the pairs of a study, and the file that it is written to."""

import os
import threading
from collections.abc import Mapping
from pathlib import Path

from mimeline.errors import BadConfig, BadFile
from mimeline.studio.rating_file import QUESTIONS, UNSEEN, Rating, read_ratings, write_ratings
from mimeline.studio.study import Pair, Study
from mimeline.studio.watched import Stamp, alone, is_tidy, revision, stamp, unwritten

MOST_CHARACTERS = 40  # of a person's name


class Rated:
    """The file is the truth: each answer is on disk when `answer` returns, and what others write
    into it meanwhile is read before, and kept.

    file: the CSV, which need not be there yet. Raises BadFile for one that cannot be read, or holds
    answers about other results.
    """

    def __init__(self, file: str | Path, study: Study, person: str):
        self.file = Path(os.path.realpath(file))  # a link stays one
        self.study, self.person = study, called(person)
        self._ratings: dict[tuple[str, str, str], Rating] = {}
        self._stamp: Stamp | str = "unread"
        self._lock = threading.Lock()
        self.refresh()

    @property
    def revision(self) -> str:
        """Another text whenever the file is another."""
        return revision([self._stamp])

    @property
    def done(self) -> int:
        """Pairs of which the person answered every question, or said that there is no picture."""
        return sum(len(self.of(pair)) == len(QUESTIONS) for pair in self.study.pairs)

    @property
    def unseen(self) -> int:
        """Pairs of which the person said that there is no picture."""
        return sum(UNSEEN in self.of(pair).values() for pair in self.study.pairs)

    def of(self, pair: str) -> dict[str, int]:
        """The person's answers on a pair, by question."""
        keys = {question: (self.person, pair, question) for question in QUESTIONS}
        return {q: self._ratings[key].answer for q, key in keys.items() if key in self._ratings}

    def refresh(self) -> None:
        """Read the file if it is another."""
        with self._lock:
            self._refresh()

    def answer(self, pair: Pair, answers: Mapping[str, int | None], seconds: float) -> None:
        """Write answers, by question, in place of those given before; None takes one back.

        seconds: that the person looked at the pair until then.
        """
        facts = pair.id, pair.kind, pair.clip_id, pair.view
        with self._lock, alone(self.file):
            self._refresh()
            ratings = dict(self._ratings)
            for question, said in answers.items():
                told = *facts, question, said, round(seconds, 1), self.study.results
                if said is None:
                    ratings.pop((self.person, pair.id, question), None)
                else:
                    ratings[self.person, pair.id, question] = Rating(self.person, *told)
            try:
                write_ratings(self.file, _in_order(ratings))
            except OSError as error:
                raise unwritten(self.file, error) from error
            self._ratings, self._stamp = ratings, stamp(self.file)

    def _refresh(self) -> None:
        now = stamp(self.file)
        if now == self._stamp:
            return
        ratings = read_ratings(self.file) if now else []
        if others := [r.results for r in ratings if r.results != self.study.results]:
            raise BadFile(
                self.file,
                found=f"answers about other results ({others[0]})",
                expected=f"about {self.study.run.results} as it is now ({self.study.results})",
                remedy="The run went on since, or has another truth or face: give another --file, "
                "and keep this one for what was answered then.",
            )
        self._ratings = {rating.key: rating for rating in ratings}
        self._stamp = now


def called(person: str) -> str:
    """A person's name as it stands in the file. Raises BadConfig for none."""
    if not is_tidy(person, MOST_CHARACTERS):
        raise BadConfig(
            "--person",
            found=repr(person),
            expected=f"a name of at most {MOST_CHARACTERS} characters in one line, which does not "
            "begin with =, +, - or @",
            remedy="Initials will do.",
        )
    return person


def _in_order(ratings: Mapping[tuple[str, str, str], Rating]) -> list[Rating]:
    """By person and pair as each came first, then by question."""
    persons = {rating.person: None for rating in ratings.values()}
    pairs = {(rating.person, rating.pair): None for rating in ratings.values()}
    place = {person: n for n, person in enumerate(persons)}
    ordered = sorted(pairs, key=lambda key: place[key[0]])  # of one person, as they came
    keys = [(*pair, question) for pair in ordered for question in QUESTIONS]
    return [ratings[key] for key in keys if key in ratings]

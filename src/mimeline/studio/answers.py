"""A person's answers on the clusters of a run, and the label file that they are written to."""

import os
import re
import threading
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from mimeline.annotation.label_file import (
    HEADER,
    Answer,
    RegionAnswers,
    kept_copy,
    read_label_file,
    root,
    write_label_file,
)
from mimeline.annotation.labels import Settled, settle
from mimeline.annotation.moving import meaning
from mimeline.config.sections import Label
from mimeline.errors import BadConfig, BadLabels
from mimeline.studio.clusters_of_run import ClustersOfRun
from mimeline.studio.handwritten import has_comments, keep, opening
from mimeline.studio.watched import Stamp, alone, is_tidy, revision, stamp, unwritten
from mimeline.vocabulary import NEUTRAL, SERIES_REGIONS, series_actions

MOST_CHARACTERS = 40  # of a note
NOT_SURE = Answer()
FIRST = ""  # the person who writes label.file itself
_NAME = re.compile(r"[a-z0-9_-]{1,32}")  # on some disks a capital makes no other file

Interval = tuple[str, int, int]


class Unfit(ValueError):
    """An answer that cannot be given to that cluster."""


class Answers:
    """One person's; the file is the truth.

    file: the label file, which need not be there yet. Each answer is on disk when `decide` returns.
    What others write into the file meanwhile is read before each answer, and kept; of comments,
    those at its top. Where there are others, `copy` is a copy of the file with them; `copies`, by
    region, of the file before the names of an earlier fit gave way. place: the file itself, where
    `file` is a link.
    Raises BadLabels for a file that cannot be read or does not fit the run.
    """

    def __init__(self, file: Path, run: ClustersOfRun):
        self.file, self.run = Path(file), run
        self.copy: Path | None = None
        self.copies: dict[str, Path] = {}
        self.place = Path(os.path.realpath(file))  # a link stays one
        told = run.run.config.get("label") or {}
        self._min_agreement = float(told.get("min_agreement", Label().min_agreement))
        self._given: dict[str, RegionAnswers] = {}
        self._settled: dict[str, Settled] = {}
        self._stamp: Stamp | str = "unread"
        self._opened: set[tuple[str, int]] = set()  # those that lost their names in a refit
        self._held: set[tuple[str, Answer]] = set()  # what is undone comes back, whatever it is
        self._lock = threading.Lock()
        self.refresh()

    @property
    def revision(self) -> str:
        """Another text whenever the file is another."""
        return revision([self._stamp])

    def settled(self, region: str) -> Settled:
        """How the answers hold on the present clusters."""
        return self._settled[region]

    def of(self, region: str, cluster: int) -> Answer | None:
        return self._settled[region].answers.get(cluster)

    def named(self, region: str, cluster: int) -> Answer | None:
        """The answer that a cluster has by itself or by the one it is the same as."""
        return self.of(region, self.root(region, cluster))

    def root(self, region: str, cluster: int) -> int:
        """The cluster whose name it bears."""
        return root(self._settled[region].answers, cluster)

    def unsafe(self, region: str) -> dict[int, str]:
        """Clusters that no name could be moved to and nobody looked at since, and why."""
        return dict(self._settled[region].unsafe)

    def shown(self, region: str, cluster: int) -> tuple[Interval, ...]:
        given = self._given.get(region)
        same = given is not None and given.model == self._settled[region].model
        return tuple(given.shown.get(cluster, ())) if same else ()

    def written(self) -> dict[str, RegionAnswers]:
        """Every region's, as they hold on the present fit."""
        return {
            region: RegionAnswers(settled.model, dict(settled.answers))
            for region, settled in self._settled.items()
        }

    def refresh(self) -> None:
        """Read the file if it is another."""
        with self._lock:
            self._refresh()

    def decide(
        self,
        region: str,
        cluster: int,
        was: Answer | None,
        now: Answer | None,
        shown: Iterable[Interval] = (),
    ) -> tuple[Answer | None, bool, str]:
        """Write an answer, None to take it back; was: what the person saw when answering.

        shown: the intervals that they looked at. Returns what holds (of a merger, into the root of
        the cluster named), whether it is theirs, and the revision before. The first answer in a
        region whose names were moved writes the whole region anew, keeps a copy of the file as it
        was, and leaves those open that no name could be moved to. Raises Unfit where the answer
        cannot be given.
        """
        with self._lock, alone(self.place):
            self._refresh()
            held, before = self.of(region, cluster), self.revision
            if self._rooted(region, held) not in [self._rooted(region, a) for a in (was, now)]:
                return held, False, before
            if held is not None:
                self._held.add((region, held))
            now = self._fitting(region, cluster, now)
            after = self._after(region, cluster, now, shown)
            if after != self._given.get(region):
                self._write(self._given | {region: after})
            return now, True, before

    def _rooted(self, region: str, answer: Answer | None) -> Answer | None:
        if answer is None or answer.same_as is None:
            return answer
        return replace(answer, same_as=self.root(region, answer.same_as))

    def _fitting(self, region: str, cluster: int, answer: Answer | None) -> Answer | None:
        """The answer, merged into a root; raises Unfit."""
        if answer is None:
            return None
        if answer.same_as is not None:
            if answer.action is not None or answer.note is not None:
                raise Unfit("A cluster that is the same as another has its name.")
            if answer.same_as not in self.run.regions[region].proposed.index:
                raise Unfit(f"There is no cluster {answer.same_as} to be the same as.")
            answer = self._rooted(region, answer)
            if answer.same_as == cluster:
                raise Unfit("A cluster cannot be the same as itself, nor as one that is it.")
            return answer
        if (region, answer) in self._held:
            return answer
        if answer.action not in (*series_actions(region), NEUTRAL, None):
            raise Unfit(f"That is no action of the {region}.")
        if answer.note is not None and (
            answer.action is None or not is_tidy(answer.note, MOST_CHARACTERS)
        ):
            raise Unfit(
                f"A finer name is one line of at most {MOST_CHARACTERS} characters, given with an "
                "action; it does not begin with =, +, - or @."
            )
        return answer

    def _after(
        self, region: str, cluster: int, now: Answer | None, shown: Iterable[Interval]
    ) -> RegionAnswers:
        """The region's part of the file with the answer in it."""
        settled = self._settled[region]
        answers, left = dict(settled.answers), {*settled.unsafe}
        self._opened |= {(region, number) for number in left}
        answers.pop(cluster, None)
        left.discard(cluster)
        if now is not None:
            answers[cluster] = now
        elif (region, cluster) in self._opened:  # the answer is taken back, not the need of one
            left.add(cluster)
        seen = self._seen(region)
        looked = tuple(dict.fromkeys([*seen.get(cluster, ()), *shown]))
        if looked:
            seen[cluster] = looked
        return RegionAnswers(settled.model, answers, seen, frozenset(left))

    def _seen(self, region: str) -> dict[int, tuple[Interval, ...]]:
        """What was shown of each cluster; of another fit, what now lies in one of that name."""
        settled, given = self._settled[region], self._given.get(region)
        if given is None or given.model == settled.model:
            return dict(given.shown) if given else {}
        clips = {clip_id for rows in given.shown.values() for clip_id, *_ in rows}
        clusters = self.run.clusters(region)
        by_clip = dict(iter(clusters[clusters["clip_id"].isin(clips)].groupby("clip_id")))
        seen: dict[int, list[Interval]] = {}
        for before, (clip_id, start, end) in (
            (number, interval) for number, rows in given.shown.items() for interval in rows
        ):
            if (own := by_clip.get(clip_id)) is None:
                continue
            for number in own.loc[own["frame"].between(start, end - 1), "cluster"].mode()[:1]:
                now = settled.answers.get(number)
                if now and now.action == meaning(given.clusters, before).action:
                    seen.setdefault(int(number), []).append((clip_id, start, end))
        return {number: tuple(dict.fromkeys(rows)) for number, rows in seen.items()}

    def _refresh(self) -> None:
        now = stamp(self.file)
        if now == self._stamp:
            return
        given = read_label_file(self.file) if now else {}
        if unknown := [region for region in given if region not in SERIES_REGIONS]:
            raise BadLabels(
                self.file,
                found=f"region {unknown[0]!r}",
                expected=f"one of {', '.join(SERIES_REGIONS)}",
                remedy="Correct the region's name.",
            )
        self._hold(given)
        self._stamp = now

    def _hold(self, given: Mapping[str, RegionAnswers]) -> None:
        settled = {}
        for name, region in self.run.regions.items():
            if not len(region.proposed):
                continue
            own = given.get(name)
            if name in self._settled and own == self._given.get(name):
                settled[name] = self._settled[name]
                continue
            settled[name] = settle(
                str(self.file),
                own,
                name,
                region.fingerprint,
                self.run.clusters(name),
                self.run.folder / "fits",
                self._min_agreement,
            )
        self._given, self._settled = dict(given), settled

    def _write(self, answers: Mapping[str, RegionAnswers]) -> None:
        ordered = {name: answers[name] for name in SERIES_REGIONS if name in answers}
        try:
            self._keep_names(ordered)
            write_label_file(self.place, ordered, self._opening())
        except OSError as error:
            raise unwritten(self.file, error) from error
        self._hold(ordered)
        self._stamp = stamp(self.file)

    def _keep_names(self, after: Mapping[str, RegionAnswers]) -> None:
        """A copy of the file where a region's names give way to those of another fit."""
        for region, given in self._given.items():
            if given.clusters and given.model != after[region].model:
                copy = kept_copy(self.place, region, given.model)
                keep(copy, self.place.read_text(encoding="utf-8"))
                self.copies[region] = copy

    def _opening(self) -> str:
        """What the file begins with; keeps a copy of it where other comments would be lost."""
        if self._stamp is None:
            return HEADER
        text = self.place.read_text(encoding="utf-8")
        begin = opening(text)
        if has_comments(text.removeprefix(begin)):
            self.copy = self.place.with_name(f"{self.place.name}.bak")
            keep(self.copy, text)
        return begin or HEADER


class Persons:
    """Whoever answers: the first into the label file, others into files of their own beside it."""

    def __init__(self, file: Path, run: ClustersOfRun):
        self.file, self.run = Path(file), run
        self._answers: dict[str, Answers] = {}
        self._lock = threading.Lock()

    def of(self, person: str) -> Answers:
        """Raises BadConfig for a name that is none, BadLabels for a file that cannot be read."""
        person = called(person)
        with self._lock:
            if person not in self._answers:
                self._answers[person] = Answers(self.path(person), self.run)
            return self._answers[person]

    def path(self, person: str) -> Path:
        return self.file.with_name(f"{self.file.stem}.{person}.yaml") if person else self.file

    def names(self) -> list[str]:
        """The first, and those who have a file."""
        begin = f"{self.file.stem}."
        beside = self.file.parent.glob("*.yaml") if self.file.parent.is_dir() else ()
        found = (p.stem.removeprefix(begin) for p in beside if p.stem.startswith(begin))
        return [FIRST, *sorted(filter(_NAME.fullmatch, found))]


def called(person: str) -> str:
    """A person's name as it stands in a file's. Raises BadConfig where it cannot."""
    name = person.lower()
    if name != FIRST and not _NAME.fullmatch(name):
        raise BadConfig(
            "--person",
            found=repr(person),
            expected="at most 32 letters, digits, - and _",
            remedy="The name becomes a part of the file's name: choose a short one.",
        )
    return name

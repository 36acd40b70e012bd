"""Videos that lie elsewhere: taken over the network, in part or whole, and given back after."""

import json
import logging
import random
import shutil
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote, urlsplit

import imageio_ffmpeg

from mimeline.atomic import whole
from mimeline.clips.catalogues.videos import ENDINGS
from mimeline.clips.source import Footage
from mimeline.errors import BadConfig, BadFile, MimelineError
from mimeline.media import transfer
from mimeline.media.limits import Limits, Refused, check_bytes, check_video
from mimeline.media.probe import probe
from mimeline.media.remote import (
    Address,
    Broken,
    Declined,
    Gone,
    TurnedAway,
    Unreachable,
    take_piece,
    told_by,
)
from mimeline.media.signature import kind_of

log = logging.getLogger(__name__)

Taken = TypeVar("Taken")
LONGEST_WAIT_S = 300.0  # that a server may ask of us; beyond it, a later run asks again
OURS = {"User-Agent": "mimeline"}


@dataclass(frozen=True)
class Terms:
    """How videos are downloaded.

    folder: where they lie until they are cut. url: address with {source_id}. max_height: pixels.
    attempts: how often what may succeed is tried. stall_s: silence that ends an attempt, seconds.
    keep: downloads stay. pause_s: before the second attempt; it doubles, give or take a half.
    """

    folder: Path
    url: str
    max_height: int
    attempts: int
    stall_s: float
    keep: bool
    pause_s: float


class Download:
    """A source at an address. alone: one clip is cut out of it, so that a piece will do.

    Raises BadConfig if the address is no file's and yt-dlp is not installed.
    """

    lasting = True  # why a clip cannot be cut is noted, so as not to download it again for that

    def __init__(self, source_id: str, terms: Terms, limits: Limits, *, alone: bool):
        self.terms, self.limits, self.alone = terms, limits, alone
        self.address = terms.url.replace("{source_id}", quote(source_id, safe=""))
        self.name = self.address
        ending = Path(urlsplit(self.address).path).suffix.lower()
        self._ending = ending if ending in ENDINGS else None
        self._note = terms.folder / f"{source_id}.json"
        self._folder = terms.folder / f"{source_id}.d"
        self._piece = self._folder / "piece.nut"
        self._footage: Footage | MimelineError | None = None
        self._site = None if self._ending else _website()

    def key(self) -> dict:
        """What tells that it is the same video."""
        return {"address": self.address, "max_height": self.terms.max_height}

    def stamp(self) -> list[int] | None:
        """Size and time of the whole download while it lies here: it may be another by now."""
        path = next(self._folder.glob("whole.*"), None)
        if path is None:
            return None
        status = path.stat()
        return [status.st_size, status.st_mtime_ns]

    def footage(self, since_s: float, until_s: float) -> Footage:
        """These seconds, or the whole video.

        Raises Gone, Unreachable, Broken or NotDownloaded; Refused beyond the limits; OSError if the
        disk is full.
        """
        if self._footage is None:
            try:
                self._footage = self._taken(since_s, until_s)
            except MimelineError as error:
                error.file = self.address  # what lies here is gone when this is read
                self._footage = error
        if isinstance(self._footage, MimelineError):
            raise self._footage
        return self._footage

    def close(self, *, settled: bool) -> None:
        """All clips are done. settled: none of them may come out better of the same download."""
        self._piece.unlink(missing_ok=True)
        if settled and not self.terms.keep and self._folder.is_dir():
            shutil.rmtree(self._folder)
            if "gone" not in self._remembered():
                self._note.unlink(missing_ok=True)

    def _taken(self, since_s: float, until_s: float) -> Footage:
        known = self._remembered()
        if "gone" in known:
            raise self._gone()
        if known.get("max_height") != self.terms.max_height and self._folder.is_dir():
            shutil.rmtree(self._folder)
        self._folder.mkdir(parents=True, exist_ok=True)
        self._piece.unlink(missing_ok=True)  # a run was killed over it
        try:
            return self._in_part_or_whole(since_s, until_s)
        except Gone as error:
            self._remember(gone=error.found)
            shutil.rmtree(self._folder, ignore_errors=True)
            raise self._gone() from error

    def _gone(self) -> Gone:
        """The error that the note speaks of."""
        known = self._remembered()
        found = f"{known['gone']} on {known['at'][:10]}"
        remedy = f"Put the video in fetch.folder, or delete {self._note} to ask again."
        return Gone(self.address, found, remedy)

    def _in_part_or_whole(self, since_s: float, until_s: float) -> Footage:
        if self.alone and not any(self._folder.iterdir()):
            try:
                return self._persist(lambda: self._in_part(since_s, until_s))
            except Declined as error:
                log.info("%s is taken whole: %s", self.address, error)
        return self._persist(self._whole)

    def _in_part(self, since_s: float, until_s: float) -> Footage:
        parts = [Address(self.address, OURS)] if self._ending else self._parts()
        sound = parts[1] if len(parts) > 1 else None
        how = (since_s, until_s, self._piece, self.limits, self.terms.stall_s)
        try:
            video, whole_s = take_piece(self.address, parts[0], sound, *how)
        except (Gone, TurnedAway) as error:
            if self._ending is None:  # the site gave an address that serves others
                raise Declined(error.found) from error
            raise
        except BadFile as error:
            if isinstance(error, Refused):
                raise
            raise Declined(error.found) from error
        return Footage(self._piece, video, whole_s)

    def _parts(self) -> list[Address]:
        facts = self._asked(None)
        self._check(facts)
        return [Address(url, headers) for url, headers in facts["parts"]]

    def _whole(self) -> Footage:
        path, as_given = next(self._folder.glob("whole.*"), None), False
        if path is None:
            self._remember(max_height=self.terms.max_height)
            made, as_given = self._transferred() if self._ending else self._found()
            path = made.rename(made.with_name(f"whole{made.suffix}"))
        try:
            video = probe(path, self.limits)
        except BadFile as error:
            if isinstance(error, Refused):
                raise
            with path.open("rb") as file:
                kind = kind_of(file.read(512))
            path.unlink()
            if kind:
                raise TurnedAway(self.address, kind) from error
            fault = Broken if as_given else Unreachable
            raise fault(self.address, error.found) from error
        return Footage(path, video, video.duration_s)

    def _transferred(self) -> tuple[Path, bool]:
        """The download, and whether it surely is the file as the server has it."""
        target = self._folder / f"video{self._ending}"
        task = {
            "address": self.address,
            "headers": OURS,
            "target": str(target),
            "max_bytes": self.limits.max_bytes,
            "stall_s": self.terms.stall_s,
        }
        facts = told_by(transfer.__file__, task, self.address, self._patient())
        return target, facts["as_given"]

    def _found(self) -> tuple[Path, bool]:
        """As `_transferred`, of what yt-dlp finds; it checks the lengths itself."""
        taken_up = any(self._folder.iterdir())
        facts = self._asked(self._folder / "video")
        self._check(facts)
        return Path(facts["path"]), not taken_up

    def _patient(self) -> Limits:
        """A download may take as long as the longest video plays."""
        longest_s = max(self.limits.timeout_s, self.limits.max_source_s)
        return replace(self.limits, timeout_s=longest_s)

    def _asked(self, target: Path | None) -> dict:
        task = {
            "address": self.address,
            "target": target and str(target),
            "max_height": self.terms.max_height,
            "max_pixels": self.limits.max_pixels,
            "max_source_s": self.limits.max_source_s,
            "max_bytes": self.limits.max_bytes,
            "stall_s": self.terms.stall_s,
            "ffmpeg": imageio_ffmpeg.get_ffmpeg_exe(),
        }
        limits = self._patient() if target else self.limits
        return told_by(self._site, task, self.address, limits)

    def _check(self, facts: dict) -> None:
        check_video(self.address, facts["width"], facts["height"], facts["length_s"], self.limits)
        check_bytes(self.address, facts["bytes"], self.limits)

    def _persist(self, act: Callable[[], Taken]) -> Taken:
        """The outcome of act, which is tried again while it may succeed."""
        chance = random.Random(self.address)
        for attempt in range(1, self.terms.attempts + 1):
            try:
                return act()
            except Unreachable as error:
                asked_s = error.retry_after_s or 0.0
                last = attempt == self.terms.attempts or asked_s > LONGEST_WAIT_S
                if last or isinstance(error, TurnedAway):
                    raise
                pause_s = self.terms.pause_s * 2 ** (attempt - 1) * chance.uniform(0.5, 1.5)
                log.info("%s; again in %.0f s", error, max(pause_s, asked_s))
                time.sleep(max(pause_s, asked_s))
        raise AssertionError("fetch.attempts is at least 1")

    def _remember(self, **facts) -> None:
        now = datetime.now(UTC).isoformat(timespec="seconds")
        with whole(self._note) as temporary:
            temporary.write_text(json.dumps({"address": self.address, "at": now} | facts))

    def _remembered(self) -> dict:
        """What was noted of this address; nothing of another."""
        try:
            known = json.loads(self._note.read_text())
            return known if known["address"] == self.address else {}
        except (OSError, ValueError, KeyError, TypeError):
            return {}


def remove_leftovers(terms: Terms, source_ids: Collection[str]) -> None:
    """Remove downloads that no clip is cut out of any more, unless downloads stay."""
    if terms.keep or not terms.folder.is_dir():
        return
    for path in terms.folder.glob("*.d"):
        if path.name.removesuffix(".d") not in source_ids:
            shutil.rmtree(path)


def _website() -> str:
    """The child that asks sites."""
    try:
        from mimeline.media import website  # yt-dlp comes with an extra
    except ImportError as error:
        raise BadConfig(
            "fetch.url",
            found="no yt-dlp to download with",
            expected="it to be installed",
            remedy="pip install 'mimeline[download]', or set fetch.url to null.",
        ) from error
    return website.__file__

"""Whose recordings a run's clips are, and whether what was made of them may be passed on."""

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any, Literal

import pandas as pd
import yaml

from mimeline.errors import BadFile, NotPermitted
from mimeline.reporting import words
from mimeline.run import Run
from mimeline.vocabulary import resource

Redistribution = Literal["permitted", "forbidden", "unknown"]
OWN = "recordings"  # what clips are called whose data set nobody has named
TABLE = "licences.yaml"


@dataclass(frozen=True)
class DataSet:
    """A set of recordings that clips of a run are of.

    licence: its name, or in words; empty: not told. licence_id: as the Hugging Face hub knows it,
    None where it does not. redistribution: of what is made from the recordings. overridden: the
    user passes it on although that is not permitted, as far as is known. consent: what the
    people in them agreed to; empty: not told. personal: whether there are people in them.
    """

    name: str
    clips: tuple[str, ...]
    licence: str
    licence_id: str | None
    redistribution: Redistribution
    overridden: bool
    consent: str
    personal: bool
    page: str
    cite: str


@dataclass(frozen=True)
class Told:
    """What the user says of data sets; each text may begin with NAME=, as where there are several.

    data_sets: NAME or NAME=PATTERN, of the ids of clips or sources. licences, consents: TEXT or
    NAME=TEXT. redistribute: names of those that are passed on all the same. contact: who answers
    the people that are shown.
    """

    data_sets: Sequence[str] = ()
    licences: Sequence[str] = ()
    consents: Sequence[str] = ()
    redistribute: Sequence[str] = ()
    contact: str = ""


def data_sets(run: Run, clips: pd.DataFrame, told: Told) -> list[DataSet]:
    """The data sets that clips are of, those that hold some, each with what is known and told.

    clips: the columns clip_id and source_id. Raises BadFile where a clip is of none of those that
    were named, or something is told of one that no clip is of.
    """
    of = _named(clips, told.data_sets) if told.data_sets else {of_run(run): list(clips["clip_id"])}
    licences = _by_name("--licence", told.licences, list(of))
    consents = _by_name("--consent", told.consents, list(of))
    overridden = {_known(name, list(of), "--redistribute") for name in told.redistribute}
    return [
        _data_set(name, ids, licences.get(name), consents.get(name), name in overridden)
        for name, ids in of.items()
    ]


def require_permission(found: Sequence[DataSet], results: Path) -> None:
    """Raises NotPermitted for the first data set that may not be passed on, as far as is known."""
    for own in found:
        if own.redistribution == "permitted" or own.overridden:
            continue
        flag = shlex.join(["--redistribute", own.name])
        told = shlex.join(["--licence", f"{own.name}=cc-by-4.0"])
        if own.redistribution == "forbidden":
            what = f"a licence that forbids passing on what is made of it ({own.licence})"
            remedy = f"Where its owners permit it to you, or nobody else gets the folder: {flag}."
        elif own.licence:
            what = f"the licence {own.licence!r}, of which nobody here knows what it permits"
            remedy = f"Read it, and where it permits passing on what is made of it: {flag}."
        else:
            what = "no licence"
            remedy = f"Tell it, as {told}; or, where you know that you may: {flag}."
        if own.page:
            remedy += f" Its terms: {own.page}."
        elif own.name == OWN:
            remedy += " A name for it: --data-set NAME."
        expected = f"a licence that permits it, for {words.clips(len(own.clips))} are of it"
        raise NotPermitted(
            results, place=f"data set {own.name}", found=what, expected=expected, remedy=remedy
        )


def of_run(run: Run) -> str:
    """The data set that a run's catalogue tells of; OWN where it tells of none."""
    config = run.config
    if not config:
        return OWN
    told = config.get("catalogue", {}).get("format") if config.get("data_dir") else "toy"
    known = _table()["data_sets"].items()
    return next((name for name, facts in known if facts.get("catalogue") == told), OWN)


def licence_of_all(found: Sequence[DataSet]) -> str:
    """What a card's `license` says: an identifier of the hub, or `other`."""
    ids = {own.licence_id if own.redistribution == "permitted" else None for own in found}
    return (ids.pop() if len(ids) == 1 else None) or "other"


def as_json(own: DataSet) -> dict[str, Any]:
    """A data set as plain values: for programs."""
    return {
        "name": own.name,
        "clips": len(own.clips),
        "licence": own.licence or None,
        "licence_id": own.licence_id,
        "redistribution": own.redistribution,
        "redistributed_all_the_same": own.overridden and own.redistribution != "permitted",
        "consent": own.consent or None,
        "page": own.page or None,
        "cite": own.cite or None,
    }


def _data_set(
    name: str, ids: list[str], licence: str | None, consent: str | None, overridden: bool
) -> DataSet:
    facts = _table()["data_sets"].get(name, {})
    permission = facts.get("redistribution", "unknown")
    if permission == "forbidden":  # what its owners forbid, no other word permits
        said, known_id = facts["licence"] + (f"; told: {licence}" if licence else ""), None
    else:
        said = licence or facts.get("licence", "")
        known_id = _licence_id(said)
    if known_id:
        said = _licences()[known_id]["name"]
    if licence and permission != "forbidden":
        permission = _licences()[known_id]["redistribution"] if known_id else "unknown"
    return DataSet(
        name=name,
        clips=tuple(ids),
        licence=said,
        licence_id=known_id,
        redistribution=permission,
        overridden=overridden,
        consent=consent or facts.get("consent", ""),
        personal=facts.get("personal", True),
        page=facts.get("page", ""),
        cite=facts.get("cite", ""),
    )


def _named(clips: pd.DataFrame, told: Sequence[str]) -> dict[str, list[str]]:
    """Data set → its clips: of several patterns that fit a clip, the first counts."""
    patterns = []
    for text in told:
        name, _, pattern = text.partition("=")
        patterns.append((_canonical(name.strip()), pattern or "*"))
    found: dict[str, list[str]] = {name: [] for name, _ in patterns}
    for clip in clips[["clip_id", "source_id"]].itertuples():
        ids = (clip.clip_id, clip.source_id)
        fits = (name for name, p in patterns if any(fnmatchcase(i, p) for i in ids))
        if (name := next(fits, None)) is None:
            raise BadFile(
                "--data-set",
                found=f"no data set for clip {clip.clip_id!r}",
                expected="one for each clip",
                remedy="Name the one that all others are of last, without a pattern.",
            )
        found[name].append(clip.clip_id)
    return {name: ids for name, ids in found.items() if ids}


def _by_name(option: str, told: Sequence[str], names: list[str]) -> dict[str, str]:
    """Data set → what is told of it. A text without a name is of the only one."""
    found = {}
    for text in told:
        name, equals, said = text.partition("=")
        if equals and _canonical(name.strip()) in names:
            found[_canonical(name.strip())] = said.strip()
        elif len(names) == 1 and not equals:
            found[names[0]] = text.strip()
        else:
            _known(name.strip(), names, option)
    return found


def _known(name: str, names: list[str], option: str) -> str:
    if _canonical(name) in names:
        return _canonical(name)
    raise BadFile(
        option,
        found=f"data set {name!r}",
        expected=f"one that clips are of: {words.listing(names)}",
        remedy="Write its name, then =, then what is to be said of it."
        if option != "--redistribute"
        else "Each data set is named by itself, so that none is passed on unseen.",
    )


def _canonical(name: str) -> str:
    """The name as the table writes it."""
    return next((n for n in _table()["data_sets"] if n.casefold() == name.casefold()), name)


def _licence_id(text: str) -> str | None:
    """The identifier that a licence's name means: `CC BY 4.0`, `cc-by-4.0` → cc-by-4.0."""

    def bare(name: str) -> str:
        return re.sub(r"licen[cs]e|[^a-z0-9.]+", "", name.casefold())

    known = _licences().items()
    return next((i for i, own in known if bare(text) in (bare(i), bare(own["name"]))), None)


def _licences() -> dict[str, dict[str, str]]:
    return _table()["licences"]


@cache
def _table() -> Mapping[str, dict[str, dict[str, Any]]]:
    return yaml.safe_load(resource(TABLE).read_text(encoding="utf-8"))

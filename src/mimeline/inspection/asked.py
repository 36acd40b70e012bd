"""The clips that a person means by ids, patterns and sources."""

import difflib
import shlex
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from mimeline.clips.exclusions import FILM
from mimeline.errors import BadFile
from mimeline.inspection.remedies import named
from mimeline.reporting import words

NEAR = 6  # names to offer instead of one that nobody has
ENOUGH = 4  # letters that tell a name
ALIKE = 0.5  # share of letters, from which names resemble each other
GLOB = set("*?[")


def meant(
    asked: Iterable[str], known: Iterable[str], clips: pd.DataFrame, results: Path
) -> tuple[list[str], str, list[str]]:
    """The ids that are asked for, each once; the source, where it is one's name; what is none.

    Raises BadFile where every name is none.
    """
    known, found, of, missed = sorted(known), {}, "", []
    for name in asked:
        bare = name.removesuffix(FILM)
        if own := {name, bare} & set(known):
            clip_id = name if name in own else bare
            ids = [clip_id, *(k for k in known if k.startswith(f"{clip_id}#"))]
        elif ids := list(clips.index[clips["source_id"] == bare]):
            of = bare
        elif GLOB & set(name):
            ids = [k for k in known if fnmatchcase(k, name)]
        if not ids:
            missed.append(_nobody(name, known, clips, results))
        found |= dict.fromkeys(ids)
    if not found:
        raise missed[0]
    return list(found), of, list(map(str, missed))


def _nobody(name: str, known: list[str], clips: pd.DataFrame, results: Path) -> BadFile:
    near = _near(name.removesuffix(FILM), known, list(pd.unique(clips["source_id"])))
    offered = ", ".join(near[:NEAR]) + (", …" if len(near) > NEAR else "")
    funnel = shlex.join(["mimeline", "funnel", *named(results)])
    return BadFile(
        results,
        place=f"clip {name!r}",
        found="no clip of that name",
        expected=f"one of its {words.count(len(known))} clips, a source, or a pattern such as 'a*'",
        remedy=f"Near it: {offered}." if near else f"{funnel} lists what there is.",
    )


def _near(name: str, known: list[str], sources: list[str]) -> list[str]:
    """Clips, then sources, that hold the name, else that resemble it, else that it holds."""
    names, folded = [*known, *sources], name.casefold()
    holding = [k for k in names if folded in k.casefold()]
    alike = [n for of in (known, sources) for n in difflib.get_close_matches(name, of, NEAR, ALIKE)]
    held = [k for k in names if len(k) >= ENOUGH and k.casefold() in folded]
    return holding or list(dict.fromkeys([*alike, *held]))

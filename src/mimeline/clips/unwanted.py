"""Actions that nobody wants in a clip."""

from collections.abc import Sequence

import numpy as np
import pandas as pd


def unwanted(actions: pd.Series, lengths: np.ndarray, names: Sequence[str]) -> list[list[dict]]:
    """Per clip, those of its actions that bear one of the names and may touch it.

    actions: per clip, name, start_s, end_s and uncertainty_s in seconds of the clip. lengths: (n,)
    seconds. An action counts where its times, with what is uncertain about them, reach into the
    clip; one whose times or uncertainty nobody knows counts. Blanks and underscores are one.
    """
    spelt = {_spelt(name) for name in names}
    return [
        [act for act in acts if _spelt(act["name"]) in spelt and _touches(act, length)]
        for acts, length in zip(actions, lengths, strict=True)
    ]


def told(acts: Sequence[dict]) -> str:
    """The actions with their times, `turn (2–3 s ± 1)`."""
    return ", ".join(map(_timed, acts))


def _spelt(name: str) -> str:
    return name.strip().replace(" ", "_")


def _touches(act: dict, length: float) -> bool:
    early, late, give = act["start_s"], act["end_s"], act.get("uncertainty_s")
    return not _known(early, late, give) or (early - give <= length and late + give >= 0)


def _timed(act: dict) -> str:
    early, late, give = act["start_s"], act["end_s"], act.get("uncertainty_s")
    if not _known(early, late):
        return act["name"]
    about = f" ± {give:g}" if _known(give) and give else ""
    return f"{act['name']} ({early:.3g}–{late:.3g} s{about})"


def _known(*seconds: float | None) -> bool:
    return not any(second is None or np.isnan(second) for second in seconds)

"""How well a face's shapes come through as ARKit channels, and how fast.

python benchmarks/mapping.py MODEL [--markdown]

MODEL: a face whose shapes bear channel names (ICT-FaceKit), so that what ought to come out is
known: it is mapped to the embedded face as if its names were unknown, through landmarks and
without. Of each channel: the quality that the mapping gives itself; what a coefficient of 1 alone
comes back as; the correlation of what is sent with what comes back over sparse expressions, in
parentheses without landmarks; and which other channel answers most.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from mimeline.face.load import load_face
from mimeline.face.motion import driver
from mimeline.face.retarget import retargeting
from mimeline.vocabulary import EXPRESSIONS

NAMES = [name for name in EXPRESSIONS if not name.startswith("eyeLook")]  # eyes tell these
FRAMES, ACTIVE = 20_000, 4


def sent(n: int) -> np.ndarray:
    """Expressions (n, S) with few channels active in each."""
    rng = np.random.default_rng(0)
    S = len(NAMES)
    return rng.uniform(0.2, 1, (n, S)) * (rng.random((n, S)) < ACTIVE / S)


def correlations(expressions: np.ndarray, back: np.ndarray) -> np.ndarray:
    """(S,) of what is sent with what comes back, NaN where nothing does."""
    a, b = expressions - expressions.mean(0), back - back.mean(0)
    with np.errstate(invalid="ignore"):
        return (a * b).sum(0) / np.sqrt((a**2).sum(0) * (b**2).sum(0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("--markdown", action="store_true")
    options = parser.parse_args()
    source, target = load_face(options.model), load_face(None)
    drives = np.array([[driver(s) == name for s in source.shape_names] for name in NAMES], float)
    start = time.perf_counter()
    way = retargeting(source, target, NAMES)
    built = time.perf_counter() - start
    unmarked = retargeting(replace(source, landmarks=None), target, NAMES)
    few, many = sent(2000), sent(FRAMES) @ drives
    r, r_unmarked = (correlations(few, w.coefficients(few @ drives)) for w in (way, unmarked))
    alone = way.coefficients(drives)  # (S, S)
    edge, gap = ("| ", " | ") if options.markdown else ("", "  ")
    print(edge + gap.join(["channel", "quality", "of 1 comes", "r", "besides"]) + edge[::-1])
    if options.markdown:
        print("|---|---|---|---|---|")
    for number, name in enumerate(NAMES):
        others = np.nan_to_num(alone[number])
        others[number] = 0
        cells = [name, f"{way.quality[number]:.2f}"]
        if not way.possible[number]:
            cells += ["not possible", "", ""]
        elif not drives[number].any():
            cells += ["the model has none", "", ""]
        else:
            besides = f"{NAMES[others.argmax()]} {others.max():.2f}"
            cells += [f"{alone[number, number]:.2f}"]
            cells += [f"{r[number]:.2f} ({r_unmarked[number]:.2f})", besides]
        print(edge + gap.join(cells) + edge[::-1])
    way.coefficients(many[:10])
    start = time.process_time()
    way.coefficients(many)
    rate = FRAMES / (time.process_time() - start)
    found = np.isfinite(r)
    print(f"mean r {r[found].mean():.2f} of {found.sum()} channels, {way.possible.sum()} possible")
    print(
        f"built in {built:.1f} s; {rate:,.0f} frames/s of one core, {rate / 20_000:.1f} of 20,000"
    )


if __name__ == "__main__":
    main()

"""How many sentences the embedded reader understands, and how long the worst text takes.

python benchmarks/sentences.py [--quiet]

The sentences are those of tests/directions/sentences.txt, with what a person means by each. right:
read as meant; wrong: read otherwise; refused: with the words that were not understood. The worst
texts fill the length that is allowed with one thing over and over; the unit is a sentence of eight
words, read in the same run.
"""

import argparse
import time
from collections import Counter
from fractions import Fraction
from pathlib import Path

from mimeline.directions.sentences import MOST_CHARACTERS, NotUnderstood, read
from mimeline.timeline.timeline import Timeline

SENTENCES = Path(__file__).parents[1] / "tests" / "directions" / "sentences.txt"
FPS = Fraction(100)
SIMPLE = "smile from 1 s to 2 s, then look left"
REPEATED = ("a ", "1 ", "smile ", "smile, ", "look left and ", "from 1 to ", "one and a half ")


def told(timeline: Timeline) -> str:
    """A timeline as the file has it."""
    ordered = sorted(timeline, key=lambda own: (own.start, own.end, own.action))
    return ", ".join(
        f"{own.action}{f' {own.side}' if own.side else ''} {own.start / 100:g}-{own.end / 100:g}"
        for own in ordered
    )


def reading(text: str) -> tuple[str, str]:
    """What it was read as, or the empty string and why it was refused."""
    try:
        return told(read(text, FPS)[0]), ""
    except NotUnderstood as error:
        return "", str(error).removeprefix("the text: found ").split(", expected")[0]


def seconds(text: str, repeats: int = 5) -> float:
    def once() -> float:
        start = time.perf_counter()
        reading(text)
        return time.perf_counter() - start

    return min(once() for _ in range(repeats))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quiet", action="store_true", help="the shares alone")
    quiet = parser.parse_args().quiet
    counts: Counter = Counter()
    batch = ""
    batches: dict[str, Counter] = {}
    for line in SENTENCES.read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            batch = line.strip("[]").partition(":")[0]
            counts = batches.setdefault(batch, Counter())
        elif line and not line.startswith("#"):
            text, _, meant = (part.strip() for part in line.removeprefix("! ").partition("|"))
            found, why = reading(text)
            outcome = "refused" if not found else "right" if found == meant else "wrong"
            counts[outcome] += 1
            if not quiet:
                print(f"{outcome:8}{text}\n        {found or why}")
    for batch, counts in batches.items():
        shares = ", ".join(f"{counts[kind]} {kind}" for kind in ("right", "wrong", "refused"))
        print(f"{batch}: {shares}, of {counts.total()}")
    unit = seconds(SIMPLE)
    worst = {one: seconds(one * (MOST_CHARACTERS // len(one))) for one in REPEATED}
    slowest = max(worst, key=worst.get)
    print(f'worst text, "{slowest}" over and over: {worst[slowest] / unit:.0f} x "{SIMPLE}"')
    print(f"({worst[slowest] * 1000:.0f} ms against {unit * 1000:.2f} ms)")


if __name__ == "__main__":
    main()

"""How often the intervals of `mimeline ratings` hold the true share, beside those of plain answers.

python benchmarks/ratings.py [--studies 300]

Studies are drawn from persons and pairs that differ, pairs more than persons or persons more than
pairs (standard deviations .7 and 1 of the log-odds, or 1.5 and .7; some 85 % agree). A 95 %
interval should hold the share of all persons and pairs in 95 of 100 studies. The other interval
takes all answers for independent, as is often done.
"""

import argparse

import numpy as np

from mimeline.studio.ratings import interval

SIZES = ((1, 15), (2, 15), (3, 10), (3, 15), (5, 15), (10, 15), (21, 15))  # persons, pairs
AGREE = 2.2  # log-odds
SPREADS = ((0.7, 1.0), (1.5, 0.7))  # of persons, of pairs


def chance(logit: np.ndarray) -> np.ndarray:
    return 1 / (1 + np.exp(-logit))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--studies", type=int, default=300)
    studies = parser.parse_args().studies
    rng = np.random.default_rng(0)
    for spread in SPREADS:
        true = chance(AGREE + np.hypot(*spread) * rng.standard_normal(10**6)).mean()
        print(f"persons differ by {spread[0]}, pairs by {spread[1]}; true share {true:.3f}")
        print(f"{studies} studies of each size")
        print("persons  pairs   crossed: holds  width   independent: holds  width")
        for persons, pairs in SIZES:
            (held, width), plain = coverage(persons, pairs, spread, true, studies, rng)
            told = f"{held:14.2f} {width:6.2f}       {plain[0]:14.2f} {plain[1]:6.2f}"
            print(f"{persons:7d} {pairs:6d}   {told}")


def coverage(
    persons: int,
    pairs: int,
    spread: tuple[float, float],
    true: float,
    studies: int,
    rng: np.random.Generator,
) -> list[tuple[float, float]]:
    """(share of the studies whose interval holds the true share, mean width): of the interval of
    `mimeline ratings`, and of the one that takes answers for independent."""
    held, width = np.zeros(2), np.zeros(2)
    for _ in range(studies):
        person = spread[0] * rng.standard_normal((persons, 1))
        pair = spread[1] * rng.standard_normal((1, pairs))
        agrees = rng.random((persons, pairs)) < chance(AGREE + person + pair)
        low, high, _ = interval(agrees, np.ones_like(agrees), 400, rng)
        share = agrees.mean()
        reach = 1.96 * np.sqrt(share * (1 - share) / agrees.size)
        both = np.array([[low, high], [share - reach, share + reach]])
        held += (both[:, 0] <= true) & (true <= both[:, 1])
        width += both[:, 1] - both[:, 0]
    return list(zip(held / studies, width / studies, strict=True))


if __name__ == "__main__":
    main()

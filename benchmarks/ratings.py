"""How often the intervals of `mimeline ratings` hold the true share, beside those of plain answers.

python benchmarks/ratings.py [--studies 300]

Studies are drawn from persons and pairs that differ (standard deviations .7 and 1 of the log-odds,
some 85 % agree). A 95 % interval should hold the share of all persons and pairs in 95 of 100
studies. The other interval takes all answers for independent, as is often done.
"""

import argparse

import numpy as np

from mimeline.studio.ratings import interval

SIZES = ((1, 15), (3, 10), (3, 15), (5, 15), (10, 15), (21, 15))  # persons, pairs
AGREE, OF_PERSONS, OF_PAIRS = 2.2, 0.7, 1.0  # log-odds


def chance(logit: np.ndarray) -> np.ndarray:
    return 1 / (1 + np.exp(-logit))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--studies", type=int, default=300)
    studies = parser.parse_args().studies
    rng = np.random.default_rng(0)
    spread = np.hypot(OF_PERSONS, OF_PAIRS)
    true = chance(AGREE + spread * rng.standard_normal(10**6)).mean()
    print(f"true share {true:.3f}; {studies} studies of each size")
    print("persons  pairs   crossed: holds  width   independent: holds  width")
    for persons, pairs in SIZES:
        held, width = np.zeros(2), np.zeros(2)
        for _ in range(studies):
            person = OF_PERSONS * rng.standard_normal((persons, 1))
            pair = OF_PAIRS * rng.standard_normal((1, pairs))
            agrees = rng.random((persons, pairs)) < chance(AGREE + person + pair)
            low, high, _ = interval(agrees, np.ones_like(agrees), 400, rng)
            share = agrees.mean()
            reach = 1.96 * np.sqrt(share * (1 - share) / agrees.size)
            both = np.array([[low, high], [share - reach, share + reach]])
            held += (both[:, 0] <= true) & (true <= both[:, 1])
            width += both[:, 1] - both[:, 0]
        told = [f"{held[n] / studies:14.2f} {width[n] / studies:6.2f}" for n in (0, 1)]
        print(f"{persons:7d} {pairs:6d}   {told[0]}       {told[1]}")


if __name__ == "__main__":
    main()

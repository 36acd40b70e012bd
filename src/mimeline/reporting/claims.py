"""What the paper says of its experiments, and whether these recordings agree."""

from collections.abc import Mapping
from dataclasses import dataclass

from mimeline.evaluation.attempts import BOUNDARIES, JOINED, REFERENCE
from mimeline.reporting.paired import Compared, Estimate, Key

ALIKE = 0.03  # the paper calls what differs by .01 to .03 similar
LITTLE = 0.01  # macro-F1 that makes no difference in practice
SAME, TIE, OTHER = "as in the paper", "a tie", "the other way round"
HARDLY, APART = "hardly a difference", "not the same"


@dataclass(frozen=True)
class Claim:
    """better does better than worse; or, where alike, they do much the same.

    place: in the paper · difference: of which two, in words · better, worse: a setting, by region;
    a region that is absent cannot tell.
    """

    text: str
    place: str
    difference: str
    better: Mapping[str, Key]
    worse: Mapping[str, Key]
    alike: bool = False


@dataclass(frozen=True)
class Verdict:
    """difference: of the better to the worse; kind: same, tie or other, than in the paper."""

    words: str
    kind: str
    difference: Estimate


def claims(compared: Mapping[str, Compared], configured: Mapping[str, Mapping]) -> list[Claim]:
    """The paper's, as far as the settings are there.

    configured: by region its n_clusters, beta and boundary.
    """

    def every(key: Key) -> dict[str, Key]:
        return {region: key for region, own in compared.items() if key in own.counts}

    def beyond(experiment: str, key: str, end) -> dict[str, Key]:
        """The setting at an end of a grid, where the configured one does not lie there itself."""
        found = {}
        for region, own in compared.items():
            numbers = {float(name): name for tried, name in own.counts if tried == experiment}
            here = float(configured[region][key])
            if numbers and end(*numbers, here) != here:
                found[region] = (experiment, numbers[end(numbers)])
        return found

    reference = every(REFERENCE)
    nulls = every(("separators", BOUNDARIES["paper"]))
    nulls |= {r: REFERENCE for r in reference if configured[r]["boundary"] == "paper"}
    joined = every(("separators", JOINED))
    fewest, most = (beyond("clusters", "n_clusters", end) for end in (min, max))
    found = [
        Claim("Too few clusters do worse", "Fig. 6", "configured − fewest", reference, fewest),
        Claim("Too many clusters do worse", "Fig. 6", "configured − most", reference, most),
        Claim("Too small a beta does worse", "Fig. 7, brow", "configured − smallest",
              reference, beyond("beta", "beta", min)),
        Claim("Too large a beta does worse", "Fig. 7, brow", "configured − largest",
              reference, beyond("beta", "beta", max)),
        Claim("Null sequences do better than no separator", "Fig. 7, brow",
              "null sequences − one sequence", nulls, joined),
        Claim("Blendshapes do better than action units", "Fig. 7, brow",
              "blendshapes − action units", reference, every(("descriptors", "action units"))),
        Claim("Unseen clips come out much the same", "4.1", "unseen − fitted as well",
              every(("unseen", "unseen")), reference, alike=True),
        Claim("One side is enough", "3.1, without a score", "both sides − one side",
              every(("sides", "both sides")), reference, alike=True),
        Claim("Thresholds alone do worse", "1 and 3.1, without a score", "TICC − thresholds",
              reference, every(("baselines", "thresholds"))),
    ]  # fmt: skip
    return [claim for claim in found if claim.better.keys() & claim.worse.keys()]


def verdicts(claim: Claim, compared: Mapping[str, Compared]) -> dict[str, Verdict]:
    """By region."""
    found = {}
    for region, own in compared.items():
        if region in claim.better and region in claim.worse:
            difference = own.difference(claim.better[region], claim.worse[region])
            found[region] = verdict(difference, claim.alike)
    return found


def verdict(difference: Estimate, alike: bool = False, little: float = LITTLE) -> Verdict:
    """Of a difference that is above 0 in the paper, or, where alike, next to nothing.

    little: what makes no difference in practice.
    """
    if alike:
        if difference.low >= -ALIKE and difference.high <= ALIKE:
            return Verdict(SAME, "same", difference)
        if difference.tie:
            return Verdict(TIE, "tie", difference)
        return Verdict(APART, "other", difference)
    if difference.tie:
        return Verdict(TIE, "tie", difference)
    if abs(difference.value) < little:
        return Verdict(HARDLY, "tie", difference)
    words, kind = (SAME, "same") if difference.value > 0 else (OTHER, "other")
    return Verdict(words, kind, difference)

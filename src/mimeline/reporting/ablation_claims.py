"""What the paper says of its variants, and whether it comes out so here."""

from collections.abc import Mapping
from dataclasses import dataclass

from mimeline.evaluation.variants import OURS, Variant
from mimeline.reporting.ablation_scores import Study
from mimeline.reporting.claims import LITTLE, Verdict, verdict

SCORES = ("tas", "conflict", "drift")  # what LITTLE holds for
LITTLE_SHARE = 0.05  # of ours, of every other metric: less makes no difference in practice
DIVIDED = "the seeds do not agree"


@dataclass(frozen=True)
class Claim:
    """The metric is higher for `more` than for `less`; place: where the paper says so."""

    text: str
    place: str
    metric: str
    more: str
    less: str


@dataclass(frozen=True)
class Judged:
    """paper: the difference in the paper's table, None where it has none."""

    claim: Claim
    difference: str
    verdict: Verdict
    paper: float | None


def judged(
    study: Study,
    variants: Mapping[str, Variant],
    branch_layers: int,
    paper: Mapping[tuple[str, str], float],
) -> list[Judged]:
    """The claims about variants that are there.

    branch_layers: as configured. paper: by row and metric of its table.
    """
    found = []
    for claim in claims(variants, branch_layers):
        difference = study.difference(claim.more, claim.less, claim.metric)
        if difference is None:
            continue
        ours = abs(study.score(OURS, claim.metric).value)
        little = LITTLE if claim.metric in SCORES else LITTLE_SHARE * ours
        said = verdict(difference, little=little)
        if said.kind != "tie" and difference.least <= 0 <= difference.most:
            said = Verdict(DIVIDED, "tie", difference)
        rows = [variants[name] for name in (claim.more, claim.less)]
        there = [paper.get((row.paper, claim.metric)) for row in rows]
        gap = None if None in there else there[0] - there[1]
        words = " − ".join(row.title[0].lower() + row.title[1:] for row in rows)
        found.append(Judged(claim, words, said, gap))
    return found


def claims(variants: Mapping[str, Variant], branch_layers: int) -> list[Claim]:
    """Those of which both variants are there."""
    depths = {v.changes["branch_layers"]: name for name, v in variants.items()
              if v.changes.get("branch_layers") and v.changes["base_layers"]}  # fmt: skip
    deepest = depths[max(depths)] if max(depths, default=0) > branch_layers else ""
    found = [
        Claim("Without branches motion is inaccurate", "4.2", "tas", OURS, "no-branch"),
        Claim("So it is where actions conflict", "3.2; our timelines", "conflict",
              OURS, "no-branch"),
        Claim("Without a base accuracy suffers", "Table 2", "tas", OURS, "no-base"),
        Claim("Without a base motion is less natural", "Table 2", "snd", "no-base", OURS),
        Claim("Without a base the head no longer goes with the eyes", "Fig. 9", "drift",
              OURS, "no-base"),
        Claim("A branch for each region is inaccurate", "4.2", "tas", OURS, "regions"),
        Claim("A branch for each region is stiff", "4.2", "var", OURS, "regions"),
        Claim("The timeline itself at each layer adds accuracy", "4.2", "tas", OURS, "carried"),
        Claim("More branch layers are less natural", "4.2", "snd", deepest, OURS),
        Claim("Dropping nothing hampers generalisation", "4.2", "tas", OURS, "drop-0"),
        Claim("Dropping too much costs accuracy", "4.2", "tas", OURS, "drop-0.7"),
        Claim("Dropping more is more natural", "4.2", "snd", OURS, "drop-0.7"),
    ]  # fmt: skip
    return [claim for claim in found if {claim.more, claim.less} <= set(variants)]

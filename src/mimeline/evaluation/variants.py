"""The ablation study of Ma et al. 2025, Table 2: which variants of the timeline model it has."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

UNSEEN, CONFLICT = ASKED = ("unseen", "conflict")  # sets of timelines, asked of each
# Motion of the unseen timelines, with eyes that are given: so many times as far as the clips' own.
NARROW, WIDE = "narrow", "wide"
EYES = {NARROW: 0.75, WIDE: 1.25}
MADE = (*ASKED, *EYES)
OURS = "ours"
PAPER_LAYERS, PAPER_BRANCH = 8, 2  # of the paper's network in all, and of its branches
PAPER_PARTS = {"branches": "halves", "timeline_tokens": "initial", "drop_each": 0.5}
DROPS = (0.0, 0.3, 0.5, 0.7)


@dataclass(frozen=True)
class Variant:
    """A row of the table.

    name: of its folder. title: what the table calls it. changes: its keys of train.timeline that
    differ from the configured. paper: the row of the paper's table beside it, or empty.
    """

    name: str
    title: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    paper: str = ""


def variants(configured: Mapping[str, Any], wanted: Collection[str]) -> dict[str, Variant]:
    """By name: the configured model first, then what differs from it, each difference once.

    configured: the keys of train.timeline. wanted: of ablations.variants. No variant has more or
    fewer layers than the configured model. The paper's own model stands beside the configured one
    where that has the same parts.
    """
    parts = bool(configured["base_layers"] and configured["branch_layers"])
    same = parts and all(configured[key] == value for key, value in PAPER_PARTS.items())
    found = {OURS: Variant(OURS, "Ours", {}, "Ours" if same else "")}
    different = [configured]
    for kind, variant in _every(configured):
        options = {**configured, **variant.changes}
        if kind in wanted and options not in different:
            found[variant.name] = variant
            different.append(options)
    return found


def _every(configured: Mapping[str, Any]) -> Iterator[tuple[str, Variant]]:
    """(a name of ablations.variants, a variant of that kind)."""
    base, branch = configured["base_layers"], configured["branch_layers"]
    layers = base + branch
    alone = {"base_layers": layers, "branch_layers": 0}
    yield "no-branch", Variant("no-branch", "w/o branch", alone, "w/o branch")
    apart = {"base_layers": 0, "branch_layers": layers}
    yield "no-base", Variant("no-base", "w/o base", apart, "w/o base")
    if branch:
        regions = {"branches": "regions"}
        yield "regions", Variant("regions", "all decoupled", regions, "all decoup.")
    carried = {"timeline_tokens": "carried"}
    yield "carried", Variant("carried", "w/o time con.", carried, "w/o time con.")
    for own in range(1, layers):
        depth = {"base_layers": layers - own, "branch_layers": own}
        name, paper = f"branch-layers-{own}", _paper_depth(own, layers)
        yield "depth", Variant(name, f"branchL{own}", depth, paper)
    for drop in DROPS:
        text = f"{drop:g}"
        paper = f"drop {text}" if drop != 0.5 else "Ours"
        yield "drop", Variant(f"drop-{text}", f"drop {text}", {"drop_each": drop}, paper)


def _paper_depth(branch: int, layers: int) -> str:
    """The paper's row with the same share of the layers in its branches."""
    share = Fraction(branch, layers) * PAPER_LAYERS
    if share == PAPER_BRANCH:
        return "Ours"
    return f"branchL{share}" if share in (1, 3, 4) else ""

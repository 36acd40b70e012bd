"""Which clips came through each stage, and why the others did not."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.errors import BadFile
from mimeline.reporting import words
from mimeline.reporting.gauge import Gauge, gauge

# in the order that clips pass them
STAGES = ("catalogue", "select", "fetch", "ingest", "pose", "split")
STATUSES = ("kept", "dropped", "failed")
MOST_ROWS = 400  # lost clips that are listed; more are counted
MOST_NAMED = 6  # clips named beside a note


@dataclass(frozen=True)
class Stage:
    """A stage's clips: in = kept + dropped + failed; reasons: words and number, most first."""

    name: str
    kept: int
    dropped: int
    failed: int
    reasons: list[tuple[str, int]]

    @property
    def entered(self) -> int:
        return self.kept + self.dropped + self.failed


@dataclass(frozen=True)
class Loss:
    """A clip that did not come through, in words.

    span: first and last frame that broke the rule, where they are known.
    """

    clip_id: str
    stage: str
    status: str
    rule: str
    reason: str
    value: str
    limit: str
    frames: str
    detail: str
    gauge: Gauge | None
    span: tuple[int, int] | None


@dataclass(frozen=True)
class Note:
    """Something the ledger says about clips that were kept; example: the first clip's detail."""

    stage: str
    text: str
    clips: int
    named: list[str]
    example: str


@dataclass(frozen=True)
class Planted:
    """A fault that was planted, and whether its stage met it."""

    clip_id: str
    fault: str
    expected: str
    found: str
    met: bool


@dataclass(frozen=True)
class Funnel:
    stages: list[Stage]
    losses: list[Loss]
    unlisted: int
    notes: list[Note]
    planted: list[Planted] = field(default_factory=list)

    @property
    def entered(self) -> int:
        return self.stages[0].entered if self.stages else 0

    @property
    def kept(self) -> int:
        return self.stages[-1].kept if self.stages else 0


def funnel(
    ledgers: Sequence[str | Path],
    truth: str | Path | None = None,
    through: Collection[str] | None = None,
) -> Funnel:
    """The way of the clips through the stages.

    ledgers: `ledger` tables, several shards of several stages. truth: a folder that may hold
    faults.csv (clip_id, fault, stage, status), the faults that were planted. through: the clips
    that came out at the end, where they are known.
    Raises BadFile unless the clips that enter a stage are those that the one before it kept.
    """
    rows = _read(ledgers)
    order = _order(rows)
    reconcile(rows, order, ledgers, through)
    lost = rows[rows["status"] != "kept"].copy()
    lost["place"] = lost["stage"].map(order.index)
    lost = lost.sort_values(["place", "rule", "clip_id"], kind="stable")
    return Funnel(
        stages=[_stage(name, rows[rows["stage"] == name]) for name in order],
        losses=[_loss(row) for row in _varied(lost).itertuples()],
        unlisted=max(len(lost) - MOST_ROWS, 0),
        notes=_notes(rows, order),
        planted=_planted(rows, truth),
    )


def _varied(lost: pd.DataFrame) -> pd.DataFrame:
    """Of more than are listed, the first of each stage and rule, the second of each, and so on."""
    turn = lost.groupby(["place", "rule"], dropna=False).cumcount()
    return lost[turn.rank(method="first") <= MOST_ROWS]


def _read(ledgers: Sequence[str | Path]) -> pd.DataFrame:
    """The rows of all ledgers, with the number of the file that each comes from."""
    parts = [tables.read(tables.LEDGER, path).assign(file=n) for n, path in enumerate(ledgers)]
    filled = [part for part in parts if len(part)] or parts[:1]
    rows = pd.concat(filled) if filled else tables.empty(tables.LEDGER).assign(file=0)
    return rows.sort_values(list(tables.LEDGER.order), kind="stable", ignore_index=True)


def _order(rows: pd.DataFrame) -> list[str]:
    """The stages, up to the last that decided on a clip; all of them where none came through."""
    present = set(rows["stage"])
    last = max((STAGES.index(stage) for stage in present if stage in STAGES), default=-1)
    ended = rows[(rows["stage"] == STAGES[last]) & (rows["status"] == "kept")]
    known = STAGES if ended.empty else STAGES[: last + 1]
    return [*known, *sorted(present - set(STAGES))]


def reconcile(
    rows: pd.DataFrame,
    order: Sequence[str],
    ledgers: Sequence[str | Path],
    through: Collection[str] | None,
) -> None:
    """Raise BadFile where a clip is decided on twice, or lost between two stages or at the end."""
    before: set[str] | None = None
    name_before = ""
    for name in order:
        stage = rows[rows["stage"] == name]
        if twice := _decided_twice(stage):
            raise _bad(ledgers, name, f"clip {twice[0]!r} twice", "one decision per clip")
        entered = set(stage["clip_id"])
        if before is not None and entered != before:
            odd = sorted(entered ^ before)
            side = "never came in" if odd[0] in entered else "has no decision"
            raise _bad(
                ledgers,
                name,
                f"clip {odd[0]!r}, which {side} ({len(odd)} such)",
                f"the {len(before)} clips that {name_before} kept",
            )
        before = set(stage.loc[stage["status"] == "kept", "clip_id"])
        name_before = name
    if through is not None and before is not None and set(through) != before:
        odd = sorted(set(through) ^ before)
        found = f"{len(set(through))} clips at the end, clip {odd[0]!r} amiss"
        raise _bad(ledgers, name_before, found, f"the {len(before)} clips that it kept")


def _decided_twice(stage: pd.DataFrame) -> list[str]:
    """Clips in two ledgers of a stage, or with rows besides the one that says why they are gone."""
    clips = stage.assign(gone=stage["status"] != "kept").groupby("clip_id")
    facts = clips.agg(files=("file", "nunique"), rows=("file", "size"), gone=("gone", "any"))
    return list(facts.index[(facts["files"] > 1) | (facts["gone"] & (facts["rows"] > 1))])


def _bad(ledgers: Sequence[str | Path], stage: str, found: str, expected: str) -> BadFile:
    own = [str(path) for path in ledgers if stage in Path(path).parts]
    return BadFile(
        ", ".join(own) or "the ledgers",
        place=f"stage {stage}",
        found=found,
        expected=expected,
        remedy="The tables are of different runs: delete the stage's results and run it again.",
    )


def _stage(name: str, rows: pd.DataFrame) -> Stage:
    counts = rows.drop_duplicates("clip_id")["status"].value_counts()
    reasons = rows.loc[rows["status"] != "kept", "rule"].map(words.rule).value_counts()
    return Stage(
        name,
        *(int(counts.get(status, 0)) for status in STATUSES),
        reasons=sorted(((str(r), int(n)) for r, n in reasons.items()), key=lambda x: (-x[1], x[0])),
    )


def _loss(row) -> Loss:
    frames, span = "", None
    if pd.notna(row.first_frame):
        last = row.first_frame if pd.isna(row.last_frame) else row.last_frame
        span = (int(row.first_frame), int(last))
        frames = f"{span[0]}" if span[0] == span[1] else f"{span[0]}–{span[1]}"
    detail = "" if pd.isna(row.detail) else row.detail
    return Loss(
        row.clip_id,
        row.stage,
        row.status,
        "" if pd.isna(row.rule) else row.rule,
        words.rule(row.rule),
        words.measure(row.value, row.unit),
        words.measure(row.limit, row.unit),
        frames,
        detail,
        gauge(row.value, row.limit),
        span,
    )


def _notes(rows: pd.DataFrame, order: Sequence[str]) -> list[Note]:
    noted = rows[(rows["status"] == "kept") & rows["rule"].notna()].copy()
    detail = noted["detail"].fillna("")
    skipped = detail.str.startswith(words.NOT_APPLIED)
    named = noted["rule"].map(words.rule)
    why = detail.str.removeprefix(words.NOT_APPLIED)
    noted["text"] = named.where(~skipped, "rule “" + named + "” was not applied: " + why)
    partly = detail.str.startswith(words.APPLIED_IN_PART)
    noted.loc[partly, "text"] = "rule “" + named + "” was applied to some frames only"
    by_time = noted["rule"] == "split_by_time"
    noted.loc[by_time, "text"] = named + ": " + detail
    noted["example"] = detail.mask(skipped | by_time, "")
    notes = []
    for stage in order:
        for text, group in noted[noted["stage"] == stage].groupby("text", sort=True):
            first = group.sort_values("clip_id")
            ids = first["clip_id"].tolist()
            example = str(first["example"].iloc[0])
            notes.append(Note(stage, str(text), len(ids), ids[:MOST_NAMED], example))
    return notes


def _planted(rows: pd.DataFrame, truth: str | Path | None) -> list[Planted]:
    path = Path(truth) / "faults.csv" if truth else None
    if path is None or not path.is_file():
        return []
    faults = pd.read_csv(path, dtype=str, keep_default_na=False)
    if not {"clip_id", "fault", "stage", "status"} <= set(faults):
        return []
    by_key = {(r.clip_id, r.stage): r for r in rows.itertuples()}
    found = []
    for fault in faults.itertuples():
        row = by_key.get((fault.clip_id, fault.stage))
        status = row.status if row else "absent"
        expected = f"{fault.status} by {fault.stage}"
        said = f"{status} by {fault.stage}" if row else f"not seen by {fault.stage}"
        if row and status != "kept":
            said += f": {words.rule(row.rule)}"
        met = status == fault.status
        found.append(Planted(fault.clip_id, fault.fault.replace("_", " "), expected, said, met))
    return found

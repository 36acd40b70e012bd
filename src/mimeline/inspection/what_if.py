"""What other limits would change, told from what a run has left, without running anything."""

import difflib
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.clips.conditions import condition
from mimeline.clips.exclusions import read_exclusions
from mimeline.clips.pose import pose
from mimeline.clips.select import decide
from mimeline.config import checked, validate, value_of
from mimeline.errors import BadConfig, NoSuchFile
from mimeline.inspection.left_behind import has_run, rows_of, shards
from mimeline.inspection.options import from_yaml
from mimeline.reporting.funnel import STAGES
from mimeline.run import DEFAULT, recall

CONFIG = Path(DEFAULT)
YAW = "pose.max_yaw_deg"
BEFORE = {"select": "catalogue", "pose": "ingest"}  # whose clips a stage decides on
ALIKE = 0.75  # share of letters, from which a key is another one misspelt
LEAST_DEG = 1e-6  # a limit that every head breaks: the ledger then tells how far each turns


@dataclass(frozen=True)
class Change:
    """What a stage would do with other options.

    asked: the options, by key. is_now: they are those of the run. kept: clips; seconds: of them.
    reasons: clips dropped by each rule. gained, lost: clips that the stage keeps now and not with
    the options of the run, and the other way round. through: how many of the lost ones came
    through all stages that have run.
    """

    stage: str
    asked: dict[str, Any]
    is_now: bool
    kept: int
    seconds: float
    reasons: dict[str, int]
    gained: list[str]
    lost: list[str]
    through: int


@dataclass(frozen=True)
class WhatIf:
    """changes: one for each value that was asked for. now: the same with the run's own options.

    differ: clips on which the ledger says something else than the configuration would; beyond:
    stages that have run and have not seen what is gained. remedy: where they differ.
    """

    changes: list[Change]
    now: dict[str, Change]
    differ: dict[str, list[str]]
    beyond: dict[str, list[str]]
    remedy: str

    @property
    def sound(self) -> bool:
        """Whether the configuration is that of the results."""
        return not any(self.differ.values())


def what_if(
    results: Path, configs: Sequence[Path], sets: Iterable[str], ledger: pd.DataFrame
) -> WhatIf:
    """What the stages would do with other values of some keys.

    configs: configuration files, over config/config.yaml; without any, what the run itself was told
    counts, where that is known. sets: "select.max_s=12", or
    several values of a number, "select.max_s=8,10,12", or the key again for another value. ledger:
    the run's decisions.
    Raises BadConfig for a key that cannot be asked or a value that it may not have; NoSuchFile
    where the stage has not run, or where head poses that it read are no longer there.
    """
    values = configured(results, configs)
    asked: dict[str, list[Any]] = {}
    for key, given in map(_asked, sets):
        asked.setdefault(key, []).extend(given)
    several = [key for key, given in asked.items() if len(given) > 1]
    if len(several) > 1:
        raise BadConfig(
            "--set",
            place=" and ".join(several),
            found="several values of both",
            expected="several values of one key",
            remedy="Ask twice.",
        )
    run = _Run(Path(results), _checked(values))
    stages = [stage for stage in BEFORE if any(key.startswith(f"{stage}.") for key in asked)]
    end = _last_kept(ledger)
    changes, now, differ = [], {}, {}
    for stage in stages:
        own = {k: given for k, given in asked.items() if k.startswith(f"{stage}.")}
        before = run.outcome(stage, run.config)
        told = ledger[(ledger["stage"] == stage)].drop_duplicates("clip_id")
        kept = told.loc[told["status"] == "kept", "clip_id"]
        stands = set(kept) ^ set(before.index[before == ""]) if len(told) else set()
        differ[stage] = sorted(stands)
        now[stage] = run.change(stage, {k: run.value(k) for k in own}, before, before, end)
        for number in range(max(len(given) for given in own.values())):
            chosen = {key: given[min(number, len(given) - 1)] for key, given in own.items()}
            config = _checked(values, chosen)
            after = run.outcome(stage, config)
            changes.append(run.change(stage, chosen, before, after, end))
    beyond = {s: [t for t in STAGES[STAGES.index(s) + 1 :] if has_run(results, t)] for s in stages}
    remedy = "Name the run's own configuration with --config."
    if recall(results).config:
        remedy = (
            "Without --config that of the run counts."
            if configs
            else (f"Type {recall(results).command()} first.")
        )
    return WhatIf(changes, now, differ, beyond, remedy)


def configured(results: Path, configs: Sequence[Path]) -> dict[str, Any]:
    """The values of configuration files, each over those before it, as Snakemake lays them.

    Without any those of the run that made the results, where they are known.
    """
    if not configs and (known := recall(results).config):
        return known
    values: dict[str, Any] = {}
    for path in [*([CONFIG] if CONFIG.is_file() else []), *configs]:
        values = _laid_over(values, from_yaml(Path(path)))
    return values


def _laid_over(below: Mapping, above: Mapping) -> dict:
    both = {
        key: _laid_over(below[key], value)
        if isinstance(value, Mapping) and isinstance(below.get(key), Mapping)
        else value
        for key, value in above.items()
    }
    return {**below, **both}


def _checked(values: dict[str, Any], chosen: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The complete configuration, with other values of some keys. Raises the first BadConfig."""
    for key, value in (chosen or {}).items():
        section, name = key.split(".")
        values = _laid_over(values, {section: {name: value}})
    return checked(values, "--set" if chosen else "the configuration")


def _asked(text: str) -> tuple[str, list[Any]]:
    """KEY=VALUE, where a number may have several values with commas between them."""
    key, equals, told = text.partition("=")
    key, defaults = key.strip(), validate({})["select"]
    known = [*(f"select.{name}" for name in defaults), YAW]
    if key not in known or not equals:
        near = difflib.get_close_matches(key, known, 1, ALIKE) if key not in known else []
        remedy = "What another key changes shows once snakemake has run with it."
        raise BadConfig(
            "--set",
            place=text,
            found="a key that cannot be asked" if equals else "no KEY=VALUE",
            expected=f"one of {', '.join(known)}",
            remedy=f"Is it {near[0]}?" if near else remedy,
        )
    default = defaults.get(key.partition(".")[2], 0.0)
    if isinstance(default, (int, float)):
        return key, [value_of(part) for part in told.split(",")]
    if isinstance(default, list) and not told.strip().startswith("["):
        parts = [told] if key == "select.conditions" else told.split(",")
        return key, [[part.strip() for part in parts if part.strip()]]
    return key, [value_of(told)]


def _last_kept(ledger: pd.DataFrame) -> set[str]:
    """The clips that the last stage kept."""
    last = ledger[(ledger["place"] == ledger["place"].max()) & (ledger["status"] == "kept")]
    return set(last["clip_id"])


class _Run:
    """What a run has left for its stages to decide on again."""

    def __init__(self, results: Path, config: dict[str, Any]):
        self.results, self.config = results, config

    def value(self, key: str) -> Any:
        section, name = key.split(".")
        return self.config[section][name]

    def outcome(self, stage: str, config: dict[str, Any]) -> pd.Series:
        """The rule that drops each clip that came to the stage, empty for one that is kept."""
        ids = self.clips(stage)["clip_id"]
        if stage == "pose":
            turned = self.peaks.reindex(ids) > config["pose"]["max_yaw_deg"]
            return pd.Series(np.where(turned, "turned", ""), turned.index)
        options = dict(config["select"])
        listed, wishes = options.pop("exclusions"), options.pop("conditions")
        options["exclusions"] = read_exclusions(listed) if listed else {}
        found = decide(self._catalogue, conditions=[condition(w) for w in wishes], **options)
        dropped = found[found["status"] == "dropped"].set_index("clip_id")["rule"]
        return dropped.reindex(ids).fillna("")

    def change(self, stage, asked, before, after, end) -> Change:
        gained = after.index[(after == "") & (before != "")]
        lost = after.index[(after != "") & (before == "")]
        length = self.clips(stage).set_index("clip_id").eval("end_s - start_s")
        return Change(
            stage,
            asked,
            is_now=all(self.value(key) == value for key, value in asked.items()),
            kept=int((after == "").sum()),
            seconds=float(length[after.index[after == ""]].sum()),
            reasons={str(k): int(n) for k, n in after[after != ""].value_counts().items()},
            gained=sorted(gained),
            lost=sorted(lost),
            through=len(end.intersection(lost)),
        )

    def clips(self, stage: str) -> pd.DataFrame:
        """The clips that came to the stage."""
        return self._catalogue if stage == "select" else self._ingested

    @cached_property
    def _catalogue(self) -> pd.DataFrame:
        return self._table("catalogue", None)

    @cached_property
    def _ingested(self) -> pd.DataFrame:
        return self._table("ingest", ["clip_id", "start_s", "end_s"])

    def _table(self, stage: str, columns: list[str] | None) -> pd.DataFrame:
        if not has_run(self.results, stage):
            raise NoSuchFile(
                self.results / stage,
                found="no such folder",
                expected=f"the clips that {stage} kept",
                remedy=f"Run {recall(self.results).command('--until', stage)} first.",
            )
        return rows_of(self.results, stage, tables.CLIPS, columns)

    @cached_property
    def peaks(self) -> pd.Series:
        """The largest |yaw| of each clip that has a head angle, degrees."""
        rows, keys = [], self.config["pose"]
        data = self._poses(keys) if keys["format"] != "motion" else self.results
        with tempfile.TemporaryDirectory() as scratch:
            kept, ledger = Path(scratch) / "clips.parquet", Path(scratch) / "ledger.parquet"
            for folder in shards(self.results, "ingest"):
                pose(
                    clips=folder / "clips.parquet",
                    motion=folder / "motion.parquet",
                    data=data,
                    kept=kept,
                    ledger=ledger,
                    format=keys["format"],
                    options=keys.get(keys["format"], {}),
                    max_yaw_deg=LEAST_DEG,
                )
                rows.append(tables.read(tables.LEDGER, ledger))
        told = pd.concat(rows)
        return told[told["status"] == "dropped"].set_index("clip_id")["value"]

    def _poses(self, keys: dict[str, Any]) -> Path:
        """The folder under which the table of head poses lies."""
        toy = self.results / "toy" / "data"
        data, file = Path(self.config["data_dir"] or toy), keys[keys["format"]]["file"]
        if not (data / file).exists():
            unset = data == toy and not toy.is_dir()
            raise NoSuchFile(
                f"data_dir/{file}" if unset else data / file,
                place=f"pose.{keys['format']}.file",
                found="no data_dir in the configuration" if unset else "no such file or folder",
                expected="the head poses that the run read",
                remedy="Name the run's configuration with --config, or ask in the folder "
                "where it was run.",
            )
        return data

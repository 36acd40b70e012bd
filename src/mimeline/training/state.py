"""What resumes a training that was interrupted."""

import hashlib
import json
import logging
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import safetensors.torch
import torch
from torch import Tensor, nn

from mimeline.atomic import whole
from mimeline.room import room
from mimeline.training.average import Average
from mimeline.training.journal import Journal

log = logging.getLogger(__name__)

KEPT = 2  # saves: a damaged one is passed over for the one before


def key(**facts: Any) -> str:
    """The name of a training's own folder: the same only where all plain facts about it are."""
    text = json.dumps(facts, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def finished(state: str | Path) -> None:
    """Remove what would resume the model's trainings: its checkpoint stands."""
    shutil.rmtree(state, ignore_errors=True)


class State:
    """All that changes while a model learns, saved now and then.

    A save is a file of tensors and its seal, a file that holds the first one's sha256 and is
    written last: without it, a save does not count. folder: the training's own; None: nothing is
    saved.
    """

    def __init__(
        self,
        folder: str | Path | None,
        model: nn.Module,
        average: Average,
        optimiser: torch.optim.Optimizer,
        scaler: torch.amp.GradScaler | None,
        generator: torch.Generator,
        journal: Journal,
    ):
        self.folder = folder and Path(folder)
        self.model, self.average, self.optimiser = model, average, optimiser
        self.scaler, self.generator, self.journal = scaler, generator, journal

    def save(self, step: int) -> None:
        """Save after that many steps. Raises NoRoom where the disk is full."""
        if self.folder is None:
            return
        weights, seal = (self.folder / f"{step:09d}{end}" for end in (".safetensors", ".json"))
        content = safetensors.torch.save(self._tensors(step))
        sealed = {"step": step, "sha256": hashlib.sha256(content).hexdigest()}
        what = f"{len(content) / 1e6:.1f} MB of what resumes the training"
        with room(self.folder, what):
            with whole(weights) as temporary:
                temporary.write_bytes(content)
            with whole(seal) as temporary:
                temporary.write_text(json.dumps(sealed), encoding="utf-8")
        for old in self._saves()[KEPT:]:
            old.unlink()
        kept = {path.stem for path in self._saves()}
        for path in self.folder.iterdir():  # what an end at any moment left, too
            if path.stem not in kept:
                path.unlink()

    def resume(self) -> int:
        """Go back to the last sound save; gives its step, 0 where there is none."""
        for seal in self._saves() if self.folder else []:
            try:
                sha256 = json.loads(seal.read_text(encoding="utf-8"))["sha256"]
                content = seal.with_suffix(".safetensors").read_bytes()
                if hashlib.sha256(content).hexdigest() != sha256:
                    raise ValueError("the weights are not those that were sealed")
            except (OSError, ValueError, KeyError, TypeError) as error:
                log.warning("%s is damaged and passed over: %s", seal.with_suffix(""), error)
            else:
                return self._restore(safetensors.torch.load(content))
        return 0

    def _saves(self) -> list[Path]:
        """The seals, the last one first."""
        return sorted(self.folder.glob("*.json"), reverse=True)

    def _tensors(self, step: int) -> dict[str, Tensor]:
        tensors = _named("model", self.model.state_dict())
        tensors |= _named("average", self.average.model.state_dict())
        for number, moments in self.optimiser.state_dict()["state"].items():
            tensors |= _named(f"optimiser.{number}", moments)
        facts = {
            "step": step,
            "average_updates": self.average.updates,
            "scaler": self.scaler.state_dict() if self.scaler else None,
            "journal": self.journal.facts(),
        }
        tensors["generator"] = self.generator.get_state()
        tensors["facts"] = torch.tensor(list(json.dumps(facts).encode()), dtype=torch.uint8)
        return {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}

    def _restore(self, tensors: Mapping[str, Tensor]) -> int:
        facts = json.loads(bytes(tensors["facts"].tolist()))
        self.model.load_state_dict(_under("model", tensors))
        self.average.model.load_state_dict(_under("average", tensors))
        self.average.updates = facts["average_updates"]
        groups = self.optimiser.state_dict()["param_groups"]
        moments: dict[int, dict[str, Tensor]] = {}
        for name, tensor in _under("optimiser", tensors).items():
            number, kind = name.split(".")
            moments.setdefault(int(number), {})[kind] = tensor
        self.optimiser.load_state_dict({"state": moments, "param_groups": groups})
        if self.scaler:
            self.scaler.load_state_dict(facts["scaler"])
        self.generator.set_state(tensors["generator"])
        self.journal.resume(facts["step"], facts["journal"])
        return facts["step"]


def _named(prefix: str, tensors: Mapping[str, Tensor]) -> dict[str, Tensor]:
    return {f"{prefix}.{name}": tensor for name, tensor in tensors.items()}


def _under(prefix: str, tensors: Mapping[str, Tensor]) -> dict[str, Tensor]:
    start = f"{prefix}."
    return {n.removeprefix(start): tensor for n, tensor in tensors.items() if n.startswith(start)}

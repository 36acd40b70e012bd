"""Where a training runs: on which device, in which precision, in how many processes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import torch

from mimeline.errors import BadConfig

if TYPE_CHECKING:
    from accelerate import Accelerator

MIXED = {"float32": "no", "bfloat16": "bf16", "float16": "fp16"}  # accelerate's names


@dataclass(frozen=True)
class Hardware:
    """device: auto takes a CUDA GPU where there is one. precision: of the network's arithmetic;
    weights and their averages stay float32. processes: on one machine, each with a share of every
    batch.

    Raises BadConfig where this machine cannot do it.
    """

    device: Literal["auto", "cpu", "cuda"] = "auto"
    precision: Literal["float32", "bfloat16", "float16"] = "float32"
    processes: int = 1

    def __post_init__(self):
        gpus = torch.cuda.device_count()
        if self.device == "cuda" and not gpus:
            raise _bad("device", "cuda", "a CUDA GPU in this machine", "Set it to auto or cpu.")
        if self.on_cuda and self.processes > gpus:
            expected = f"at most {gpus}, a GPU each"
            raise _bad("processes", str(self.processes), expected, "Lower it, or set device: cpu.")
        if self.precision == "float16" and not self.on_cuda:
            expected = "float32 or bfloat16 on a CPU"
            raise _bad("precision", "float16", expected, "Set it to one of these.")

    @property
    def on_cuda(self) -> bool:
        return self.device == "cuda" or (self.device == "auto" and torch.cuda.is_available())

    def accelerator(self) -> "Accelerator":
        """What places the model, casts, and averages gradients over the processes."""
        from accelerate import Accelerator  # slow to import; only a training needs it
        from accelerate.state import AcceleratorState

        AcceleratorState._reset_state(reset_partial_state=True)  # else the last training's is kept
        return Accelerator(cpu=not self.on_cuda, mixed_precision=MIXED[self.precision])


def _bad(key: str, found: str, expected: str, remedy: str) -> BadConfig:
    return BadConfig(f"train.hardware.{key}", found=found, expected=expected, remedy=remedy)

"""What a frame has of its own: the part of motion that no neighbouring frame tells."""

from collections.abc import Iterable, Mapping, Sequence

import torch
from torch import Tensor, nn

MEDIAN_OF_NORMAL = 0.6745  # of the sizes of standard normal values
OUTLYING = 3.0  # standard deviations from which a value is movement


class Jitter(nn.Module):
    """Frame-to-frame jitter as a Gaussian, white in time and correlated over the channels.

    Layers that look at many frames find what is smooth; a tracker's jitter, which is not, they
    could only copy. This tells what of a noisy frame is jitter in closed form, so that the layers
    need not. parts: columns of the channels that may be correlated; others never are.
    """

    def __init__(self, channels: int, parts: Mapping[str, Sequence[int]]):
        super().__init__()
        self.parts = parts
        self.register_buffer("basis", torch.eye(channels))  # (D, D) columns are eigenvectors
        self.register_buffer("variance", torch.zeros(channels))  # (D,) of each of them

    def measure(self, clips: Iterable[tuple[Tensor, Tensor]]) -> None:
        """Set the Gaussian from clips: motion (L, D), measured (L, D) bool.

        From second differences of neighbouring frames, in which even movement cancels: those of
        white noise have six times its covariance. What sticks out of them, a blink's lid, is quick
        movement and does not count. Where nothing can be measured there is no jitter.
        """
        bends = [bent(motion, measured) for motion, measured in clips if len(motion) > 2]
        if not bends:
            return
        bend = torch.cat(bends)  # (N, D)
        size = bend.abs().nanmedian(dim=0).values / MEDIAN_OF_NORMAL  # (D,) NaN where never known
        usual = bend.abs() <= OUTLYING * size  # (N, D)
        bend, usual = bend.where(usual, 0.0).double(), usual.double()
        covariance = bend.T @ bend / (usual.T @ usual).clamp(min=1) / 6  # (D, D)
        for columns in self.parts.values():
            block = torch.as_tensor(columns)[:, None], torch.as_tensor(columns)[None, :]
            values, vectors = torch.linalg.eigh(covariance[block])
            self.basis[block] = vectors.to(self.basis)
            self.variance[columns] = values.clamp(min=0).to(self.variance)

    def _apply(self, fn, recurse=True):
        """Goes to other devices, and stays in float32: rounded, the basis is none any more."""
        return super()._apply(lambda buffer: buffer.to(fn(buffer).device), recurse)

    def forward(self, noisy: Tensor, smooth: Tensor, signal: Tensor, noise: Tensor) -> Tensor:
        """The mean of smooth + jitter, given noisy = signal (smooth + jitter) + noise eps.

        smooth + signal C (signal² C + noise²)⁻¹ (noisy − signal smooth), with C the covariance of
        the jitter (Wiener's filter; Bishop 2006, equation 2.116). noisy, smooth (B, L, D) · signal,
        noise (B, 1, 1), of `Schedule`. Returns (B, L, D).
        """
        basis, variance = self.basis.to(noisy), self.variance.to(noisy)
        gain = signal * variance / (signal**2 * variance + noise**2)  # (B, 1, D)
        with torch.autocast(noisy.device.type, enabled=False):
            return smooth + (gain * ((noisy - signal * smooth) @ basis)) @ basis.T


def bent(motion: Tensor, measured: Tensor) -> Tensor:
    """x[t−1] − 2 x[t] + x[t+1] of motion (L, D), (L − 2, D); NaN where one was not measured."""
    known = measured[2:] & measured[1:-1] & measured[:-2]  # (L - 2, D)
    bend = motion[2:] - 2 * motion[1:-1] + motion[:-2]  # (L - 2, D)
    return bend.where(known, torch.nan)

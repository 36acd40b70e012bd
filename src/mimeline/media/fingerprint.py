"""What a film looks like, in a few bits a second that survive scaling and coding."""

from pathlib import Path

import numpy as np


def fingerprint(film: Path) -> tuple[np.ndarray, np.ndarray]:
    """Frames looked at, (m,) int64, and a perceptual hash of each, (m,) int64."""
    return np.empty(0, np.int64), np.empty(0, np.int64)

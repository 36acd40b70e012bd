"""A picture as the bytes of an image file."""

from typing import Literal

import cv2
import numpy as np

QUALITY = {  # of the lossy kind
    "jpeg": [cv2.IMWRITE_JPEG_QUALITY, 85],
    "png": [],
    "webp": [cv2.IMWRITE_WEBP_QUALITY, 85],
}


def encode(picture: np.ndarray, kind: Literal["jpeg", "png", "webp"]) -> bytes:
    """picture: (H, W, 3) uint8 RGB. Returns the file's content. Raises ValueError otherwise."""
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise ValueError(f"a picture is (H, W, 3) uint8, not {picture.shape} {picture.dtype}")
    if kind not in QUALITY:
        raise ValueError(f"kind is one of {', '.join(QUALITY)}, not {kind!r}")
    done, content = cv2.imencode(f".{kind}", picture[..., ::-1], QUALITY[kind])
    if not done:
        raise ValueError(f"a picture of {picture.shape} cannot be a {kind}")
    return content.tobytes()

"""Arrays that fit a face model, or a word on why they do not."""

from collections.abc import Sequence

import numpy as np

LARGEST = 1e6  # of the numbers of a face, millimetres included: what is made of them stays finite


class Unfit(ValueError):
    """A part of a face model that does not fit the others; part, found and expected say which."""

    def __init__(self, part: str, found: str, expected: str):
        self.part, self.found, self.expected = part, found, expected
        super().__init__(f"{part}: found {found}, expected {expected}")


def fitted(name: str, value, dtype, shape: Sequence[int | None]) -> np.ndarray:
    """The value as an array of a type and a shape, where None is any length.

    Raises Unfit for another shape, for anything but finite numbers, for fractions where the type
    is one of whole numbers, and for numbers beyond that type's or LARGEST.
    """
    part, value = f"array {name}", np.asarray(value)
    if value.dtype.kind not in "iuf":
        raise Unfit(part, f"type {value.dtype}", "numbers")
    lengths = zip(value.shape, shape, strict=False)
    if value.ndim != len(shape) or not all(w is None or n == w for n, w in lengths):
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise Unfit(part, f"shape {value.shape}", f"({wanted}{',' * (len(shape) == 1)})")
    if not np.isfinite(value).all():
        raise Unfit(part, "numbers that are not finite", "finite numbers")
    least, most = -LARGEST, LARGEST
    if np.issubdtype(dtype, np.integer):
        least, most = np.iinfo(dtype).min, np.iinfo(dtype).max
        if value.dtype.kind == "f" and (value != np.rint(value)).any():
            raise Unfit(part, "fractions", "whole numbers")
    low, high = (value.min().item(), value.max().item()) if value.size else (0, 0)
    if not least <= low <= high <= most:
        raise Unfit(part, f"numbers from {low:g} to {high:g}", f"{least:g} to {most:g}")
    return np.ascontiguousarray(value, dtype)


def vertex_numbers(name: str, value, dtype, shape: Sequence[int | None], V: int) -> np.ndarray:
    """As `fitted`; raises Unfit also where a number is not one of V vertices."""
    numbers = fitted(name, value, dtype, shape)
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < V:
        found = f"numbers from {numbers.min()} to {numbers.max()}"
        raise Unfit(f"array {name}", found, f"numbers of vertices, 0-{V - 1}")
    return numbers


def names_of(name: str, value, count: int) -> list[str]:
    """The texts of an array of names. Raises Unfit unless it is a row of count texts."""
    part, value = f"array {name}", np.asarray(value)
    if value.dtype.kind != "U":
        raise Unfit(part, f"type {value.dtype}", "text")
    if value.shape != (count,):
        raise Unfit(part, f"shape {value.shape}", f"({count},), a name for each")
    return value.tolist()

"""A small synthetic world with known truth in the real file formats: demo, test bed, CI input."""

from mimeline.toy.files import make
from mimeline.toy.world import World, simulate

__all__ = ["World", "make", "simulate"]

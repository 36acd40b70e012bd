"""Toeplitz inverse covariance-based clustering, a library of its own."""

from .model import TICC

__all__ = ["TICC"]

"""Timelines as people pass them on: converted, compared, joined, checked, taken out of a run."""

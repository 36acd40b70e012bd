"""Timelines and data sets as people pass them on: converted, compared, taken out of a run."""

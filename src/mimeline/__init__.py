"""mimeline: facial-action timelines from face-tracking results, and motion generated from them."""

__version__ = "0.1.0"

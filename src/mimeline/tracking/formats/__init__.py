"""A file per format of tracking results, and what several of them share."""

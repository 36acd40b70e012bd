"""Timelines of facial actions: the type, its checks, and the files that people keep them in."""

"""The files that people keep timelines in, one module per format.

Each reads a file into drafts, as it stands, and writes timelines as text.
"""

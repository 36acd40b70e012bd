"""Face-tracking results in: one reader per format, one motion table out."""

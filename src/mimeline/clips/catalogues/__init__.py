"""What exists, read from whatever form its makers gave it: one file per kind of catalogue."""

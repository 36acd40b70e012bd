"""Face models of other people, read from the user's own files."""

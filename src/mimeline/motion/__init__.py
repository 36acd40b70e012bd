"""Motion by itself: what travels with it, and the files that other programs open."""

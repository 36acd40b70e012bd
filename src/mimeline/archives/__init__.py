"""Arrays out of files that are not trusted."""

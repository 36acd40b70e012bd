"""Sentences about what a clip shows, and how often what is shown."""

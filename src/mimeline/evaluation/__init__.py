"""Evaluation: annotations against truth, generated motion against what was asked for."""

"""Gaussian diffusion of sequences: schedules, conversions, samplers, guidance. Knows no faces."""

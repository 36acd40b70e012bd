"""Training: conditions dropped, a loop, averaged weights, checkpoints."""

"""Motion from a trained model."""

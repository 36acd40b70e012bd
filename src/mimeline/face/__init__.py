"""Face models: coefficients to vertices, landmarks and pictures."""

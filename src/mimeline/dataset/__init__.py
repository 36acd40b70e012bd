"""What a model is trained on: parts, statistics and windows of the annotated motion."""

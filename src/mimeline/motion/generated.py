"""Motion that a trained model makes of timelines, with all that is to be known of it."""

"""Networks that predict motion. They know channels and actions by name, and nothing of files."""

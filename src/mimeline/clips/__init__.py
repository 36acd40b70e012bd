"""What clips exist and which of them are worth the work."""

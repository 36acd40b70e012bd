"""Pictures and sound as arrays, and their files."""

"""What writes and reads motion, a module for each kind of file."""

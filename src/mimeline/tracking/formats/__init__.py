"""A file per format of tracking results: what it declares, its reader its writer."""

"""From motion to timelines: series, clusters, their names, intervals of actions, and scores."""

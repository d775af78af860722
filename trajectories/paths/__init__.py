"""Built-in paths, one per file, named after the trajectory; `motion()` returns the `PlannedMotion`."""

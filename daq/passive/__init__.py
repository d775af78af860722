"""Work on frames of a bus without commanding drives: listening, reconstruction, recovery, replay."""

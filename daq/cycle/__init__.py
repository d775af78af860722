"""The cycle: exchange, supervision and recording of a run that is streamed to the drives."""

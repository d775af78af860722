"""Turn parameters into intervals, and say how far they can be trusted."""

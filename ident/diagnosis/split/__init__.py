"""Rows of recordings as weights: training and held-out rows, blocks, and the noise floor."""

"""Ripple and vibrations above the low-pass of the analysis."""

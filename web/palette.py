"""Colours with the same meaning on every page and in every figure."""

# Palette of Okabe and Ito, distinguishable for colour-blind readers; each joint has the same colour everywhere.
JOINTS = ("#0072B2", "#D55E00", "#CC79A7", "#E69F00", "#56B4E9")
NOISE = "#009E73"
MEASURED = "#8A9099"
"""Measured or earlier data; a neutral colour on light and dark backgrounds."""

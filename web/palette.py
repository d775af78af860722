"""Colours that mean the same on every page and in every picture."""

# Okabe and Ito's palette, which stays distinct for colour-blind readers; each joint has the same colour everywhere.
JOINTS = ("#0072B2", "#D55E00", "#CC79A7", "#E69F00", "#56B4E9")
NOISE = "#009E73"
MEASURED = "#8A9099"
"""What was measured, or how it was before: stands back behind the colours, on light and dark ground."""

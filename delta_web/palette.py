"""Colours with the same meaning on every page and in every figure."""

# Palette of Okabe and Ito, distinguishable for colour-blind readers; each joint has the same colour everywhere.
JOINTS = ("#0072B2", "#D55E00", "#CC79A7", "#E69F00", "#56B4E9")
"""Of the joints, and of the torque that a model computes for them."""
NOISE = "#009E73"
MEASURED = "#8A9099"
"""Measured or earlier data; a neutral colour on light and dark backgrounds."""
CATEGORIES = ("#7F70D6", "#A8792B", "#C8414B")
"""What belongs to no joint. The last one is a warning."""
CAUSES = (*JOINTS, NOISE, *CATEGORIES)
"""Of the causes of a torque, in their order; used again where there are more."""

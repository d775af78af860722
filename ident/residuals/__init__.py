"""Analysis of a model's residual: by joint, phase and window, over possible influences, and by frequency."""

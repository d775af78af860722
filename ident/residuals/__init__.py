"""Where a model fails: its residual by joint, phase, window, over what it may depend on, and by frequency."""

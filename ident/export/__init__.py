"""The model at work: the torque of a path by its causes, and the model as other programs take it."""

"""Feed-forward: the torque of a model, sent to the drives as torque offset with every target."""

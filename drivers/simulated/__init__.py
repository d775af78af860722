"""The simulated rig: amplifiers on a bus around a plant of the whole robot."""

"""Turn motion into torque: mechanisms, effects, and what they share. Imports nothing above it."""

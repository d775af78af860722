"""Find the physical effect that a model lacks."""

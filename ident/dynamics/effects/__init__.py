"""Physical effects that the base model of a mechanism does not know: what they are, and where they come from."""

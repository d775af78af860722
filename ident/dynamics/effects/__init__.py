"""Physical effects that the base model of a mechanism lacks."""

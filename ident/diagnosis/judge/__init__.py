"""One judge of evidence: whether one fitted model is accepted in place of another."""

"""Search the models that a library of effects can form."""

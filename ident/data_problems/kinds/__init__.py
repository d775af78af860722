"""Kinds of data problems, one module each."""

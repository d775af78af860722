"""Kinds of data problems of recordings, one module each."""

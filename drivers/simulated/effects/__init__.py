"""The hidden effects, one file each."""

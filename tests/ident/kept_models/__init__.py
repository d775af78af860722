"""Model files, and the short recordings to which they were fitted."""

from pathlib import Path

MODELS = Path(__file__).parent
"""The folder of these files."""

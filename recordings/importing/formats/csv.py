"""Text tables of any make."""

from recordings.importing.layout import read

__all__ = ["read"]

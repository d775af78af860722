"""Pickles without what can be computed again."""

from dataclasses import fields
from typing import Any


class WithoutCaches:
    """Base of dataclasses that leave out of pickles and copies what they cache: it is computed when asked for."""

    def __getstate__(self) -> dict[str, Any]:
        """The fields, without cached properties."""
        return {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]

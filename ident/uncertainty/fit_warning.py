"""What speaks against a fitted model, or limits what it is worth."""

from dataclasses import dataclass
from typing import Literal

WarningKind = Literal["not-physical", "at-bound", "not-determined", "conditional", "held-out", "noise-floor"]
"""not-physical: no machine has such values; at-bound: the search ended at its limit; not-determined: the interval
holds zero, or an effect imitates the parameter; conditional: the intervals hold for a right model only, and structure
is left; held-out: the model predicts nothing there, or is silent; noise-floor: what counts as noise may be none."""


@dataclass(frozen=True)
class FitWarning:
    """One of them."""

    name: str
    """Of the parameters; "links" for those of all links together; of what is no parameter, the kind."""
    significant: bool
    """False if it may be chance: only a part of the 95 % interval is impossible."""
    sentence: str
    of_bodies: bool = False
    """True for masses and inertias that no body has."""
    kind: WarningKind = "not-physical"

    @property
    def line(self) -> str:
        """The sentence as it stands alone."""
        return f"Not physical: {self.sentence}." if self.kind == "not-physical" else self.sentence

"""Input and result of an estimator."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from ident.estimation.lad_certificate import Certificate
from recordings.recording import Floats


class Progress(Protocol):
    """Callback that reports the progress of a search."""

    def __call__(self, done: int, total: int, excess: float | None = None, /) -> None:
        """Report `done` steps of `total`; `excess`: relative excess of the objective over its minimum, if known."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A regression problem: torque = regressor . parameters, with m rows and k parameters."""

    regressor: Floats
    """(m, k)"""
    torque: Floats
    """(m,) [N m]"""
    bounds: Floats
    """(k, 2) search region [lowest, highest]; used only by methods with a search region."""
    deviation: Floats | None = None
    """(m,) standard deviation of the residual in each row [N m], for estimators that are WEIGHTED."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Result of an estimator."""

    parameters: Floats
    """(k,)"""
    objective: float
    """Value of the estimator's objective at `parameters`."""
    history: Floats
    """Best objective before the first step and after each step; of length one for methods without steps."""
    certificate: Certificate | None = None
    """Certified minimum of (33), if that is the estimator's objective."""
    diagnostics: Mapping[str, Any] = field(default_factory=dict)
    """Further results, JSON-serialisable."""

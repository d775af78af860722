"""What an estimator is given, and what it gives back."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from ident.estimation.lad_certificate import Certificate
from recordings.recording import Floats


class Progress(Protocol):
    """How far a search has come."""

    def __call__(self, done: int, total: int, excess: float | None = None, /) -> None:
        """`done` steps of `total`; `excess`: of the objective over its certified minimum, relative, where known."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What is to be fitted: torque = regressor . parameters, m rows, k parameters."""

    regressor: Floats
    """(m, k)"""
    torque: Floats
    """(m,) [N m]"""
    bounds: Floats
    """(k, 2) search region [lowest, highest]. Only methods that search look at it."""
    deviation: Floats | None = None
    """(m,) standard deviation of what a good fit leaves of each torque [N m], for estimators that are WEIGHTED."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What an estimator found."""

    parameters: Floats
    """(k,)"""
    objective: float
    """Value of the objective that the estimator minimises, at `parameters`."""
    history: Floats
    """Best objective so far, before the first step and after each; of length one where there are no steps."""
    certificate: Certificate | None = None
    """The minimum of (33) with its proof, where that is the estimator's objective."""
    diagnostics: Mapping[str, Any] = field(default_factory=dict)
    """What else there is to know, ready for JSON."""

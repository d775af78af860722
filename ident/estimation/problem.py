"""Input and result of an estimator."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from ident.dynamics.mechanisms.urdf import Urdf
from ident.estimation.lad_certificate import Certificate
from recordings.recording import Floats, Ints


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
    instant: Ints | None = None
    """(m,) number of the instant to which each row belongs, for estimators that are RECURSIVE."""
    links: Urdf | None = None
    """Links that least squares allows to be bodies alone; their base parameters come first."""


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
    spread: Floats | None = None
    """Of a swarm, at each step as `history`: standard deviation of its particles relative to that of an even
    distribution over the search region, mean of the dimensions."""
    diagnostics: Mapping[str, Any] = field(default_factory=dict)
    """Further results, JSON-serialisable."""

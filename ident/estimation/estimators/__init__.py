"""Estimators find the parameters. One estimator is one file here, with one signature for all:

    estimate(problem, generator, progress, settings) -> Estimate

and a frozen dataclass `Settings` of what can be set, all with defaults. A module that says `FORM = "name"` identifies
that form of the mechanism (`ident/dynamics/forms/`) instead of the mechanism's own model; one that says `WEIGHTED = True` is
told how well each torque is known.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Protocol, cast

from numpy.random import Generator

from ident import plugins
from ident.estimation.lad_certificate import Certificate
from recordings.errors import BadInput
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


class Estimator(Protocol):
    """What the module of an estimator holds."""

    Settings: type[Any]

    def estimate(self, problem: Problem, generator: Generator, progress: Progress, settings: Any) -> Estimate:
        """Solve `problem`."""
        ...


def load(name: str) -> Estimator:
    """The estimator `name`. Raises BadInput where there is none."""
    return cast(Estimator, plugins.load("estimators", name))


def form(name: str) -> str | None:
    """The form of the mechanism that the estimator `name` identifies; None: the mechanism's own model."""
    found: str | None = getattr(load(name), "FORM", None)
    return found


def weighted(name: str) -> bool:
    """Whether the estimator `name` asks for `Problem.deviation`."""
    return getattr(load(name), "WEIGHTED", False)


def has_setting(name: str, setting: str) -> bool:
    """Whether the estimator `name` has such a setting."""
    return setting in [field.name for field in fields(load(name).Settings)]


def settings(name: str, given: Mapping[str, Any]) -> Any:
    """The settings of the estimator `name`, its defaults replaced by what is `given`.

    Raises:
        BadInput: the estimator has no such setting, or refuses the value.
    """
    kind = load(name).Settings
    known = [field.name for field in fields(kind)]
    for setting in given:
        if not has_setting(name, setting):
            raise BadInput(f"method {name}: a setting of {', '.join(known) or 'none'} expected, '{setting}' found")
    return kind(**given)

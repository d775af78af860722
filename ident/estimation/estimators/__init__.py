"""Estimators find the parameters. One estimator is one file here, with one signature for all:

    estimate(problem, generator, progress, settings) -> Estimate

and a frozen dataclass `Settings` of what can be set, all with defaults. A module that says `FORM = "name"` identifies
that form of the mechanism (`ident/dynamics/forms/`) instead of the mechanism's own model; one that says
`WEIGHTED = True` is told how well each torque is known.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Protocol, cast

from numpy.random import Generator

from ident import plugins
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.errors import BadInput


class Estimator(Protocol):
    """What the module of an estimator holds."""

    Settings: type[Any]

    def estimate(self, problem: Problem, generator: Generator, progress: Progress, settings: Any) -> Estimate:
        """Solve `problem`."""
        ...


def load(name: str) -> Estimator:
    """The estimator `name`. Raises BadInput where there is none."""
    return cast(Estimator, plugins.load(__name__, name))


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

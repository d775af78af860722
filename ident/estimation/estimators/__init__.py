"""Estimators of the parameters. Each estimator is a module that defines

    estimate(problem, generator, progress, settings) -> Estimate

and a frozen dataclass `Settings`, whose fields all have defaults. With `FORM = "name"` a module identifies that form
of the mechanism (`ident/dynamics/forms/`) instead of the mechanism's own model. With `WEIGHTED = True` it receives
the standard deviation of each row.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Protocol, cast

from numpy.random import Generator

from ident import plugins
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.errors import BadInput


class Estimator(Protocol):
    """Interface of an estimator module."""

    Settings: type[Any]

    def estimate(self, problem: Problem, generator: Generator, progress: Progress, settings: Any) -> Estimate:
        """Solve `problem`."""
        ...


def load(name: str) -> Estimator:
    """Load the estimator `name`.

    Raises:
        BadInput: there is no such estimator.
    """
    return cast(Estimator, plugins.load(__name__, name))


def form(name: str) -> str | None:
    """Form of the mechanism that the estimator `name` identifies; None: the mechanism's own model."""
    form_name: str | None = getattr(load(name), "FORM", None)
    return form_name


def weighted(name: str) -> bool:
    """Whether the estimator `name` uses `Problem.deviation`."""
    return getattr(load(name), "WEIGHTED", False)


def has_setting(name: str, setting: str) -> bool:
    """Whether the estimator `name` has the setting `setting`."""
    return setting in [field.name for field in fields(load(name).Settings)]


def settings(name: str, given: Mapping[str, Any]) -> Any:
    """Create the settings of the estimator `name` from the `given` values; the others have their defaults.

    Raises:
        BadInput: the estimator has no such setting, or the value is invalid.
    """
    kind = load(name).Settings
    known = [field.name for field in fields(kind)]
    for setting in given:
        if not has_setting(name, setting):
            raise BadInput(f"method {name}: a setting of {', '.join(known) or 'none'} expected, '{setting}' found")
    return kind(**given)

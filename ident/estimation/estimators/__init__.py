"""Estimators of the parameters.

Each estimator is a module that defines

    estimate(problem, generator, progress, settings) -> Estimate

and a frozen dataclass `Settings`, whose fields all have defaults and a `Meaning` (`ident.estimation.settings`). With
`FORM = "name"` a module identifies that form of the mechanism (`ident/dynamics/forms/`) instead of the mechanism's
own model. With `WEIGHTED = True` it receives the standard deviation of each row, with `RECURSIVE = True` its instant.
With `NONLINEAR = True` a swarm with its `Settings` first searches the nonlinear parameters of effects
(`ident.estimation.nonlinear_swarm`), in place of nonlinear least squares.
"""

from collections.abc import Mapping
from typing import Any, Protocol, cast

from numpy.random import Generator

from ident.basics import plugins
from ident.estimation import settings as method_settings
from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.settings import Setting


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
    return getattr(load(name), "FORM", None)


def declares(name: str, constant: str) -> bool:
    """Whether the module of the estimator `name` sets this `constant`: WEIGHTED, RECURSIVE or NONLINEAR."""
    return getattr(load(name), constant, False)


def settings_of(name: str) -> tuple[Setting, ...]:
    """Settings that the estimator `name` has."""
    return method_settings.settings_of(load(name).Settings)


def has_setting(name: str, setting: str) -> bool:
    """Whether the estimator `name` has the setting `setting`."""
    return setting in [known.name for known in settings_of(name)]


def settings(name: str, given: Mapping[str, Any]) -> Any:
    """Create the settings of the estimator `name` from the `given` values; the others have their defaults.

    Raises:
        BadInput: the estimator has no such setting, or the value is invalid.
    """
    return method_settings.create(
        load(name).Settings, given, f"method {name}", f"`ident methods {name}` explains them"
    )

"""Estimators find the parameters. One estimator is one file here, with one signature for all:

    estimate(regressor, torque, bounds, generator, progress, settings) -> Estimate

and a frozen dataclass `Settings` of what can be set, all with defaults.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol, cast

from numpy.random import Generator

from ident import discovery
from recordings.errors import BadInput
from recordings.recording import Floats

Progress = Callable[[int, int], None]
"""Called with steps done and steps in all."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What an estimator found."""

    parameters: Floats
    """(k,)"""
    objective: float
    """Value of the objective that the estimator minimises, at `parameters`."""
    history: Floats
    """Best objective so far, before the first step and after each; of length one where there are no steps."""


class Estimator(Protocol):
    """What the module of an estimator holds."""

    Settings: type[Any]

    def estimate(
        self,
        regressor: Floats,
        torque: Floats,
        bounds: Floats,
        generator: Generator,
        progress: Progress,
        settings: Any,
    ) -> Estimate:
        """Fit torque (m,) [N m] by regressor (m, k) times parameters within bounds (k, 2)."""
        ...


def load(name: str) -> Estimator:
    """The estimator `name`. Raises BadInput where there is none."""
    return cast(Estimator, discovery.load("estimators", name))


def settings(name: str, given: Mapping[str, Any]) -> Any:
    """The settings of the estimator `name`, its defaults replaced by what is `given`.

    Raises:
        BadInput: the estimator has no such setting, or refuses the value.
    """
    kind = load(name).Settings
    known = [field.name for field in fields(kind)]
    for setting in given:
        if setting not in known:
            raise BadInput(f"method {name}: a setting of {', '.join(known) or 'none'} expected, '{setting}' found")
    return kind(**given)

"""Mechanisms turn motion into regressor columns. One mechanism is one file here, named as the rig file names it.

A mechanism's module holds `create(rig) -> Mechanism`. All that stands above works for any number of joints.
"""

from dataclasses import dataclass
from typing import Protocol, cast

from ident import plugins
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig


@dataclass(frozen=True)
class Parameter:
    """One coefficient of a regressor column."""

    name: str
    unit: str
    meaning: str
    nonnegative: bool = False
    """True for masses and inertias: the search goes no lower than zero."""
    paper_sign: int = 1
    """The paper prints this parameter times paper_sign."""
    friction: bool = False
    """True where a negative value would help the motion: no real machine has that, though a fit may."""

    @property
    def physically_positive(self) -> bool:
        """True where no real machine has a negative value."""
        return self.nonnegative or self.friction


class Mechanism(Protocol):
    """A model that is linear in its parameters: torque = regressor . parameters."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The k parameters, in the order of the columns."""
        ...

    @property
    def pointwise(self) -> bool:
        """True where the columns of an instant follow from the motion at that instant alone."""
        ...

    def regressor(self, motion: Motion) -> Floats:
        """Columns (n, dof, k), each in N m per unit of its parameter; NaN where the motion is."""
        ...

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """Torque (n, dof) [N m] of the manufacturer's model, the one to beat; None where there is none."""
        ...


def create(rig: Rig, form: str | None = None) -> Mechanism:
    """The mechanism of `rig`; with a `form`, another linear model of it (`ident/dynamics/forms/`).

    Raises:
        BadInput: there is no such form of this mechanism.
    """
    if form is None:
        return cast(Mechanism, plugins.load(__name__, rig.mechanism).create(rig))
    module = plugins.load("ident.dynamics.forms", form)
    if module.MECHANISM != rig.mechanism:
        raise BadInput(
            f"the model form '{form}' is one of the mechanism {module.MECHANISM}, {rig.mechanism} found; choose a "
            "method that needs no such form"
        )
    return cast(Mechanism, module.create(rig))

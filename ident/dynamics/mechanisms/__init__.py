"""Mechanisms compute regressor columns from motion. One mechanism is one file here, named as in the rig file.

A mechanism's module holds `create(rig) -> Mechanism`. The number of joints is not fixed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np

from ident.basics import plugins
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Vector


@dataclass(frozen=True)
class Parameter:
    """One coefficient of a regressor column."""

    name: str
    unit: str
    meaning: str
    nonnegative: bool = False
    """True for masses and inertias: the search is bounded below by zero."""
    paper_sign: int = 1
    """The paper prints this parameter multiplied by `paper_sign`."""
    friction: bool = False
    """True for friction: a negative value would drive the motion, which only an estimate can do."""

    @property
    def physically_positive(self) -> bool:
        """True if no real machine has a negative value."""
        return self.nonnegative or self.friction


def units(kind: str) -> tuple[str, str, str]:
    """Units of position, effort and inertia of a kind of joint."""
    return ("rad", "N m", "kg m^2") if kind == "revolute" else ("m", "N", "kg")


def friction_parameters(kinds: Sequence[str], paper_sign: int = 1) -> tuple[Parameter, ...]:
    """Viscous friction of joints of these `kinds`, then their Coulomb friction."""
    return tuple(
        Parameter(
            f"{name}{i}",
            unit.format(*units(kind)),
            f"{meaning} friction of joint {i}",
            paper_sign=paper_sign,
            friction=True,
        )
        for name, unit, meaning in (("c_v", "{1} s/{0}", "viscous"), ("c_c", "{1}", "Coulomb"))
        for i, kind in enumerate(kinds, start=1)
    )


class Mechanism(Protocol):
    """A model that is linear in its parameters: torque = regressor . parameters."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The k parameters, in the order of the columns."""

    def regressor(self, motion: Motion) -> Floats:
        """Compute the columns (n, dof, k), in N m per unit of the parameter; NaN where the motion is NaN.

        The columns at an instant depend on the motion at that instant alone.
        """


class RigidMechanism(Mechanism, Protocol):
    """A mechanism whose torque can be told apart by its causes."""

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """Compute the torque (n, dof) [N m] of the manufacturer's model, the reference; None if there is none."""

    def inertia(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the inertia matrix (n, dof, dof) [kg m^2 or kg] for the `parameters` (k,)."""

    def gravity(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, dof) [N m or N] that holds the mechanism at rest, for the `parameters` (k,)."""

    def torque_per_mass(self, motion: Motion, place: Vector) -> Floats:
        """Compute the torque (n, dof) [N m/kg or N/kg] of 1 kg at a `place` (3,) [m] of what the last joint moves."""


def known_masses(masses: Sequence[tuple[float, Vector]]) -> list[tuple[float, Vector]]:
    """Return those of `masses` [kg] that are not NaN, with their places [m]."""
    return [(mass, place) for mass, place in masses if not np.isnan(mass)]


def torque_of_masses(mechanism: RigidMechanism, masses: Sequence[tuple[float, Vector]], motion: Motion) -> Floats:
    """Compute the torque (n, dof) [N m or N] of the known `masses` [kg] at their places [m] of the last link."""
    torques = (mass * mechanism.torque_per_mass(motion, place) for mass, place in known_masses(masses))
    return sum(torques, start=np.zeros_like(motion.position))


def create(rig: Rig, form: str | None = None) -> RigidMechanism:
    """Create the mechanism of `rig`; with a `form`, another linear model of it (`ident/dynamics/forms/`).

    Raises:
        BadInput: there is no such form of this mechanism.
    """
    if form is None:
        return cast(RigidMechanism, plugins.load(__name__, rig.mechanism).create(rig))
    module = plugins.load("ident.dynamics.forms", form)
    if module.MECHANISM != rig.mechanism:
        raise BadInput(
            f"the model form '{form}' is one of the mechanism {module.MECHANISM}, {rig.mechanism} found; choose a "
            "method that needs no such form"
        )
    return cast(RigidMechanism, module.create(rig))

"""A load that is picked up, or lost, during the run."""

import numpy as np

from ident.effects import Additive, Quantity, Shapes
from ident.view import GRAVITY, View
from recordings.recording import Floats

_NEVER = 1e9
"""[s]"""
_CANDIDATES = 40
"""Instants that are tried."""
_BEST = 3


def columns(view: View, shapes: Shapes) -> Floats:
    """Torque that 1 kg at the platform takes while it is there (n, dof, 1)."""
    carried = (view.time >= shapes["t_c"]) & (view.time < shapes["t_e"])
    torque: Floats = np.where(carried[:, None], _per_mass(view), 0.0 * view.motion.position)[:, :, None]
    return torque


def suggest(view: View, residual: Floats) -> list[dict[str, float]]:
    """The instants at which a change of mass would explain most of the `residual` (n, dof)."""
    per_mass = _per_mass(view)
    known = np.isfinite(residual) & np.isfinite(per_mass)
    together = np.where(known, residual * per_mass, 0.0).sum(axis=1)
    squares = np.where(known, per_mass**2, 0.0).sum(axis=1)
    instants = np.linspace(view.time[0], view.time[-1], _CANDIDATES + 2)[1:-1]
    after = view.time >= instants[:, None]
    # Less what a constant mass explains, which the model has already.
    part, weight = (after * together).sum(axis=1), (after * squares).sum(axis=1)
    part = part - weight * together.sum() / squares.sum()
    weight = weight - weight**2 / squares.sum()
    gain = part**2 / np.maximum(weight, 1e-12 * squares.sum())
    return [{"t_c": float(instants[i]), "t_e": _NEVER} for i in np.argsort(-gain)[:_BEST]]


def _per_mass(view: View) -> Floats:
    """J' (P'' - g) (n, dof)."""
    lifted = view.platform.acceleration + np.array([0.0, 0.0, GRAVITY])
    torque: Floats = np.einsum("nij,ni->nj", view.platform.jacobian, lifted)
    return torque


effect = Additive(
    sentence="The platform becomes heavier or lighter at some moment of the run.",
    looks="From one moment on, the residual follows the weight and inertia of a mass at the platform.",
    causes="a gripper that picks something up or loses it, a part that came loose",
    remedy="record with the load fixed; tell the controller when the load changes",
    equation="J' dm (P'' - g) from t_c to t_e",
    axis="time",
    mechanisms=("delta",),
    whole_robot=True,
    coefficients=(Quantity(name="dm", unit="kg", meaning="mass that is added"),),
    shapes=(
        Quantity(name="t_c", unit="s", meaning="when it is added", lower=0.0, upper=_NEVER),
        Quantity(name="t_e", unit="s", meaning="when it is taken off again", upper=_NEVER, searched=False),
    ),
    suggest=suggest,
    columns=columns,
)

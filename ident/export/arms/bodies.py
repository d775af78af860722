"""Bodies of an identified arm: links whose pseudo-inertia is positive definite, nearest to the base parameters.

Nearest means: the torque along a motion differs least, on each joint over its held-out error.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.dynamics.bodies import LEAST
from ident.dynamics.mechanisms.urdf import Urdf, motor_matrix
from ident.dynamics.motion import Motion
from ident.export.losses import Carried, sorted_by
from ident.export.paths import TorquePath
from ident.identification.model import Model
from recordings.errors import BadInput, told
from recordings.recording import Floats

_OFFSET, _MOTORS = "constant_torque", "motor_inertia"
_ROWS = 2000
"""Instants of the motion along which the torques are compared."""


@dataclass(frozen=True, eq=False)
class Arm:
    """Physical parameters of an identified arm of dof joints."""

    mechanism: Urdf
    links: Floats
    """(dof, 10) `LINK_PARAMETERS` of the link that each joint moves."""
    motors: Floats
    """(dof,) inertia of each motor at its joint [kg m^2 or kg]."""
    friction: dict[str, Floats]
    """(dof,) viscous and Coulomb friction at the joints, at least 0."""
    offset: Floats
    """(dof,) constant torque [N m or N]."""
    lost: dict[str, str]
    """Causes of torque that no body has, and why."""
    lost_motors: Floats
    """(dof,) inertia of motors that turn with another joint, too, which no body has."""


def arm_of(model: Model, path: TorquePath) -> Arm:
    """Return the bodies of `model`, compared along `path`.

    Raises:
        BadInput: as `tree_of`.
    """
    mechanism = tree_of(model)
    values = base_values(model)
    dof, base = len(model.file.joints), len(mechanism.base.columns)
    agreement = (model.file.validate_ or model.file.train).fitted
    physical = _nearest(mechanism, values[:base], path.excerpt().motion, np.array(agreement.rms))
    viscous, coulomb, offset = np.split(values[base:], 3)
    coupled = np.isin(np.arange(1, dof + 1), [coupling.of for coupling in mechanism.chain.couplings])
    friction, lost = {}, {}
    for name, row in (("viscous", viscous), ("coulomb", coulomb)):
        friction[name] = np.where(coupled, 0.0, np.maximum(row, 0.0))
        if coupled.any() or (row < 0).any():
            lost[name] = (
                "that of a motor that turns with another joint" if coupled.any() else "negative: 0 is written"
            )
    links, motors = physical[: 10 * dof].reshape(dof, 10), np.zeros(dof)
    motors[: len(physical) - 10 * dof] = physical[10 * dof :]
    kept, others = np.where(coupled, 0.0, motors), np.where(coupled, motors, 0.0)
    return Arm(mechanism, links, kept, friction, offset, lost, others)


def tree_of(model: Model) -> Urdf:
    """Return the tree of links of `model`.

    Raises:
        BadInput: the model is not one of a URDF, or has joints that follow others.
    """
    mechanism = model.dynamics.structure.mechanism
    if not isinstance(mechanism, Urdf):
        raise BadInput(f"a model of the mechanism 'urdf' expected, '{model.file.mechanism}' found")
    if mechanism.links.followers:
        found = "closed loops" if mechanism.chain.loops else "joints that mimic others"
        raise BadInput(
            f"a tree of links expected, {found} found, which this export cannot carry; export its torque along a "
            f"motion to {told('--to csv', 'csv')}"
        )
    return mechanism


def base_values(model: Model) -> Floats:
    """(k,) parameters of the mechanism of `model`; 0 where an effect stands in their place."""
    structure = model.dynamics.structure
    return structure.mechanism_values(model.dynamics.values[structure.linear])


def carried_by(model: Model, arm: Arm, bodies: Sequence[str], target: str) -> Carried:
    """Sort the effects of `model` by what becomes of them where only `bodies` can be written."""
    structure = model.dynamics.structure
    reasons = {
        name: f"no element of {target}"
        for name, term in zip(structure.term_names, structure.terms, strict=True)
        if term.effect.bodies is None or not set(term.effect.bodies) <= set(bodies)
    }
    C = motor_matrix(arm.mechanism.chain)
    parts: dict[str, Callable[[Motion], Floats]] = {
        _OFFSET: lambda motion: arm.offset + 0.0 * motion.position,
        _MOTORS: lambda motion: arm.lost_motors * (motion.acceleration @ C.T) @ C,
    }
    lost = arm.lost | {_OFFSET: f"no element of {target}"} if arm.offset.any() else arm.lost
    lost |= {_MOTORS: "that of a motor that turns with another joint"} if arm.lost_motors.any() else {}
    carried = sorted_by(model, reasons, lost)
    base = ("links", *(name for name in ("viscous", "coulomb", _MOTORS) if name not in lost))
    return replace(carried, carried=(*base, *carried.carried), parts=parts)


def added_to_bodies(model: Model, names: Sequence[str]) -> dict[str, Floats]:
    """What the effects of `model` add (dof,) to the properties of bodies called `names`, joint by joint."""
    structure, dof = model.dynamics.structure, len(model.file.joints)
    added = {name: np.zeros(dof) for name in names}
    for index, term in enumerate(structure.terms):
        rows = list(range(dof)) if term.effect.whole_robot else list(term.joints)
        values = structure.local_values(index, model.dynamics.values)
        for name, column in zip(term.effect.bodies or (), values.T, strict=False):
            if name in added:
                added[name][rows] += column
    return added


def about_centre(parameters: Floats) -> tuple[float, Floats, Floats]:
    """Mass, centre of mass (3,) and inertia (3, 3) about it of a link with `LINK_PARAMETERS` (10,)."""
    mass, place = float(parameters[0]), parameters[1:4] / parameters[0]
    Ixx, Ixy, Iyy, Ixz, Iyz, Izz = parameters[4:]
    inertia = np.array([[Ixx, Ixy, Ixz], [Ixy, Iyy, Iyz], [Ixz, Iyz, Izz]])
    return mass, place, inertia - mass * (place @ place * np.eye(3) - np.outer(place, place))


def _nearest(mechanism: Urdf, base: Floats, motion: Motion, error: Floats) -> Floats:
    """(k,) physical parameters: of the links, and of the motors where they are parameters.

    error: (dof,) of the model's torque, which weighs the joints.
    """
    step = max(1, len(motion.position) // _ROWS)
    thinned = Motion(
        *(getattr(motion, name)[::step] for name in ("position", "velocity", "acceleration", "direction"))
    )
    columns = mechanism.regressor(thinned)[:, :, : len(base)] / error[:, None]
    known = columns[np.isfinite(columns).all(axis=(1, 2))]
    root = np.linalg.qr(known.reshape(-1, len(base)), mode="r") / np.sqrt(len(known))
    return mechanism.nearest_bodies(root, root @ base, LEAST)

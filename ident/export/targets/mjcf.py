"""MJCF for MuJoCo: arms, forearms and platform of a delta robot as a closed chain; `arms.mjcf` has those of a URDF.

The identified parameters are sums over bodies; the bodies written here have these sums, and inertias that bodies can
have. Each joint's inertia is an arm of uniform mass with the identified gravity torque, and the motor's armature for
the rest. MuJoCo rounds dry friction off near standstill. Joints and motors have the limits of the rig as ranges; the
key frame "level" holds the arms level.
"""

from typing import Any

import numpy as np

from ident.dynamics.motion import Motion
from ident.export.arms import mjcf as arm_mjcf
from ident.export.arms.bodies import added_to_bodies, arm_of, carried_by
from ident.export.losses import Carried, sorted_by
from ident.export.rendering import rendered
from ident.export.targets import ExportRequest
from ident.export.targets import beside as carried_file
from ident.export.xml_file import write_xml
from recordings.errors import BadInput, told
from recordings.files import replacement
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

__all__ = ["carried_file", "write"]

TIMESTEP = 2e-4
"""Of the simulation [s]."""
FRICTION_RATE = 20 / TIMESTEP
"""Rate at which dry friction stops a joint [1/s]. MuJoCo's friction has the sign of Eq. (29) at speeds above the
acceleration divided by it; a rate above 1/TIMESTEP swings at rest, but creeps less than MuJoCo's default."""
FRICTION_IMPEDANCE = (0.95, 0.95, 1e-3)
"""Stiff from the beginning."""
TINY_MASS = 1e-6
"""Of a body without identified mass [kg]."""
AXIAL_SHARE = 0.01
"""Inertia of a rod about its own axis, of that across: MuJoCo wants none to be 0."""
BODIES = ("m_d", "g_x", "g_y", "cosine", "sine", "stiffness", "torque_at_zero", "zero")
"""What effects add to, by joint or for the robot: mass of the rods of a limb [kg], horizontal gravity [m/s^2], cosine
and sine of an arm's weight, stiffness and torque at angle zero of its spring, zero of its encoder."""


def write(request: ExportRequest) -> Carried:
    """See `Target`.

    Raises:
        BadInput: the model is not one of a delta robot or of a URDF, or has a mass that no body has.
    """
    model = request.model
    if model.file.mechanism == "urdf":
        arm = arm_of(model, request.path)
        write_xml(arm_mjcf.document(model, arm), request.out)
        return carried_by(model, arm, arm_mjcf.BODIES, "MJCF")
    if model.file.mechanism != "delta" or model.file.form:
        raise BadInput(
            "a model of the mechanism 'delta' or 'urdf' expected for MJCF, another one found; export it as c or fmu"
        )
    structure, values = model.dynamics.structure, model.dynamics.values
    parameters = structure.mechanism_values(values[structure.linear])
    with replacement(request.out) as partial:
        partial.write_text(rendered("delta_robot.xml", _robot(request, parameters)), encoding="utf-8")
    terms = zip(structure.term_names, structure.terms, strict=True)
    reasons = {name: "no element of MJCF" for name, term in terms if term.effect.bodies is None}
    friction = {"viscous": parameters[5:8], "coulomb": parameters[8:11]}
    negative = {name: "negative friction: 0 is written" for name, row in friction.items() if (row < 0).any()}
    return sorted_by(model, reasons, negative)


def _robot(request: ExportRequest, parameters: Floats) -> dict[str, Any]:
    """What `templates/delta_robot.xml` needs, from the `parameters` (11,) of Eq. (26) and from the effects.

    It is in the pose where the arms are level: elbow and platform joint of each limb lie in one plane.
    """
    dynamics, added = request.model.dynamics, added_to_bodies(request.model, BODIES)
    m_p, T_g, inertia = parameters[0], parameters[1], parameters[2:5]
    for name, value in (("m_p", m_p), *((f"I_{j + 1}", x) for j, x in enumerate(inertia))):
        if value <= 0:
            lad = told("--method lad", 'method="lad"')
            raise BadInput(f"{name} above 0 expected, {value:.3g} found: no body has it; fit with {lad}")
    structure = dynamics.structure
    geometry: Geometry = structure.corrections(dynamics.values, structure.rig)[0].geometry
    centre = kinematics.forward(geometry, np.zeros((1, 3)))[0]
    across = geometry.R - geometry.r + geometry.L1
    m_d = max(added["m_d"][0], TINY_MASS)
    of_rod, of_platform = m_d * geometry.L2**2 / 12, m_p * geometry.r**2 / 2
    weights = zip(geometry.phi, inertia, T_g + added["cosine"], added["sine"], strict=True)
    arms = [_arm(geometry, *each) for each in weights]
    for limb, arm in enumerate(arms):
        stiffness, offset = added["stiffness"][limb], added["torque_at_zero"][limb]
        arm |= {
            "stiffness": stiffness,
            "rest": -offset / stiffness if stiffness else 0.0,
            "zero": added["zero"][limb],
        }
        arm |= {"viscous": max(parameters[5 + limb], 0.0), "coulomb": max(parameters[8 + limb], 0.0)}
    level, still = added["zero"][None], np.zeros((1, 3))
    return {
        "timestep": TIMESTEP,
        "gravity": [added["g_x"][0], added["g_y"][0], kinematics.GRAVITY[2]],
        "geometry": geometry,
        "limits": request.path.limits,
        "friction_rate": FRICTION_RATE,
        "friction_impedance": FRICTION_IMPEDANCE,
        "arms": arms,
        "rod": {
            "turn": _quaternion("y", np.arctan2(-centre[2], -across)),
            "mass": m_d,
            "moments": _moments(AXIAL_SHARE * of_rod, of_rod),
        },
        "centre": centre,
        "platform": {"mass": m_p, "moments": _moments(of_platform, of_platform)},
        "holding": dynamics.inputs(Motion(level, still, still, still)).load[0],
    }


def _arm(geometry: Geometry, phi: float, inertia: float, cosine: float, sine: float) -> dict[str, Any]:
    """Where an arm begins and its rod ends, and its mass, centre of mass, moments, and armature of its motor.

    Its centre of mass lies at half of L1, or nearer if the `inertia` [kg m^2] is too small for the weight:
    `cosine` and `sine` are the amplitudes of its torque [N m].
    """
    g = -kinematics.GRAVITY[2]
    along, up = cosine / g, -sine / g  # mass times distance
    lever = float(min(geometry.L1 / 2, 0.75 * inertia / max(abs(along), abs(up), TINY_MASS)))
    mass = max(float(np.hypot(along, up)) / lever, TINY_MASS)
    x, z, own = along / mass, up / mass, mass * lever**2 / 3
    return {
        "foot": [geometry.R * np.cos(phi), geometry.R * np.sin(phi), 0.0],
        "hand": [geometry.r * np.cos(phi), geometry.r * np.sin(phi), 0.0],
        "turn": _quaternion("z", phi),
        "mass": mass,
        "place": [x, 0.0, z],
        "moments": _moments(AXIAL_SHARE * own, own),
        "armature": max(inertia - own - mass * (x**2 + z**2), 0.0),
    }


def _moments(axial: float, across: float) -> list[float]:
    return [max(float(x), TINY_MASS**2) for x in (axial, across, across)]


def _quaternion(axis: str, angle: float) -> list[float]:
    """Rotation about an axis."""
    return [np.cos(angle / 2), *(np.sin(angle / 2) * np.eye(3)["xyz".index(axis)])]

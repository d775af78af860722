"""MJCF for MuJoCo: arms, forearms and platform of a delta robot as a closed chain.

The identified parameters are sums over bodies; the bodies written here have these sums, and inertias that bodies can
have. Each joint's inertia is an arm of uniform mass with the identified gravity torque, and the motor's armature for
the rest. MuJoCo rounds dry friction off near standstill.
"""

from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ident.export.losses import Carried, sorted_by
from ident.export.targets import ExportRequest
from ident.export.targets import beside as carried_file
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.files import replacement
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

__all__ = ["carried_file", "write"]

TIMESTEP = 2e-4
"""Of the simulation [s]."""
FRICTION_RATE = 20 / TIMESTEP
"""Rate at which dry friction stops a joint [1/s]. MuJoCo's friction has the sign of Eq. (21) at speeds above the
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
        BadInput: the model is not one of a delta robot, or has a mass that no body has.
    """
    model = request.model
    if model.file.mechanism != "delta" or model.file.form:
        raise BadInput("a model of the mechanism 'delta' expected for MJCF, another one found; export it as c or fmu")
    robot = _Robot(model)
    ElementTree.indent(document := robot.document())
    with replacement(request.out) as partial:
        partial.write_text(ElementTree.tostring(document, encoding="unicode") + "\n", encoding="utf-8")
    structure = model.dynamics.structure
    terms = zip(structure.term_names, structure.terms, strict=True)
    reasons = {name: "no element of MJCF" for name, term in terms if term.effect.bodies is None}
    negative = dict.fromkeys(robot.negative_friction, "negative friction: 0 is written")
    carried = sorted_by(model, reasons)
    return Carried(carried.carried, {**carried.lost, **negative}, carried.voltage)


class _Robot:
    """Physical parameters of the bodies, from those of the model."""

    def __init__(self, model: Model) -> None:
        structure, values = model.dynamics.structure, model.dynamics.values
        parameters = structure.mechanism_values(values[structure.linear])
        self.geometry: Geometry = structure.corrections(values)[0].geometry
        self.m_p, self.T_g, self.inertia = parameters[0], parameters[1], parameters[2:5]
        friction = parameters[5:8], parameters[8:11]
        self.negative_friction = [
            name for name, row in zip(("viscous", "coulomb"), friction, strict=True) if (row < 0).any()
        ]
        self.viscous, self.coulomb = (np.maximum(row, 0.0) for row in friction)
        added = _added(model)
        self.m_d = max(added["m_d"][0], TINY_MASS)
        self.tilt = [added["g_x"][0], added["g_y"][0]]
        self.cosine, self.sine = self.T_g + added["cosine"], added["sine"]
        self.spring = np.column_stack([added["stiffness"], added["torque_at_zero"]])
        self.zero = added["zero"]
        for name, value in (("m_p", self.m_p), *((f"I_{j + 1}", x) for j, x in enumerate(self.inertia))):
            if value <= 0:
                raise BadInput(f"{name} above 0 expected, {value:.3g} found: no body has it; fit with --method lad")

    def document(self) -> Element:
        """The whole model."""
        root = Element("mujoco", model="delta")
        SubElement(root, "compiler", angle="radian", autolimits="true")
        gravity = [*self.tilt, kinematics.GRAVITY[2]]
        SubElement(root, "option", timestep=_text([TIMESTEP]), gravity=_text(gravity), integrator="implicitfast")
        world = SubElement(root, "worldbody")
        centre = kinematics.forward(self.geometry, np.zeros((1, 3)))[0]
        for limb in range(3):
            self._limb(world, limb, centre)
        self._platform(world, centre)
        equality, actuator = SubElement(root, "equality"), SubElement(root, "actuator")
        for limb in (1, 2, 3):
            SubElement(equality, "connect", name=f"limb_{limb}", site1=f"rod_{limb}", site2=f"platform_{limb}")
            SubElement(actuator, "motor", name=f"joint_{limb}", joint=f"joint_{limb}")
        return root

    def _limb(self, world: Element, limb: int, centre: Floats) -> None:
        """Arm and forearm, in the pose where the arm is level: elbow and platform joint lie in one plane."""
        geometry, number, phi = self.geometry, limb + 1, self.geometry.phi[limb]
        foot = [geometry.R * np.cos(phi), geometry.R * np.sin(phi), 0.0]
        arm = SubElement(world, "body", name=f"arm_{number}", pos=_text(foot), quat=_quaternion("z", phi))
        stiffness, offset = self.spring[limb]
        SubElement(
            arm, "joint", name=f"joint_{number}", axis="0 -1 0",
            armature=_text([self._armature(limb)]), damping=_text([self.viscous[limb]]),
            frictionloss=_text([self.coulomb[limb]]), ref=_text([self.zero[limb]]),
            solreffriction=_text([-1.0, -FRICTION_RATE]), solimpfriction=_text(FRICTION_IMPEDANCE),
            stiffness=_text([stiffness]), springref=_text([-offset / stiffness if stiffness else 0.0]),
        )  # fmt: skip
        self._arm_inertia(arm, limb)
        _bar(arm, geometry.L1, "0.2 0.4 0.7 1")
        across = geometry.R - geometry.r + geometry.L1
        rod = SubElement(
            arm, "body", name=f"rod_{number}", pos=_text([geometry.L1, 0, 0]),
            quat=_quaternion("y", np.arctan2(-centre[2], -across)),
        )  # fmt: skip
        SubElement(rod, "joint", name=f"elbow_{number}", axis="0 -1 0")
        SubElement(rod, "joint", name=f"swing_{number}", axis="0 0 1")
        whole = self.m_d * geometry.L2**2 / 12
        _inertial(rod, self.m_d, [geometry.L2 / 2, 0, 0], [AXIAL_SHARE * whole, whole, whole])
        _bar(rod, geometry.L2, "0.6 0.6 0.6 1")
        SubElement(rod, "site", name=f"rod_{number}", pos=_text([geometry.L2, 0, 0]))

    def _lever(self, limb: int) -> float:
        """Distance of the arm's centre of mass [m]: half of L1, or less if the inertia is too small for it."""
        moment = max(abs(self.cosine[limb]), abs(self.sine[limb])) / -kinematics.GRAVITY[2]
        return float(min(self.geometry.L1 / 2, 0.75 * self.inertia[limb] / max(moment, TINY_MASS)))

    def _arm_inertia(self, arm: Element, limb: int) -> None:
        mass, place, inertia = self._arm(limb)
        _inertial(arm, mass, place, [AXIAL_SHARE * inertia, inertia, inertia])

    def _arm(self, limb: int) -> tuple[float, list[float], float]:
        """Mass [kg], centre of mass [m], and inertia across about it [kg m^2] of an arm without its motor."""
        lever, g = self._lever(limb), -kinematics.GRAVITY[2]
        along, up = self.cosine[limb] / g, -self.sine[limb] / g  # mass times distance
        mass = max(float(np.hypot(along, up)) / lever, TINY_MASS)
        return mass, [along / mass, 0.0, up / mass], mass * lever**2 / 3

    def _armature(self, limb: int) -> float:
        mass, place, inertia = self._arm(limb)
        return float(max(self.inertia[limb] - inertia - mass * (place[0] ** 2 + place[2] ** 2), 0.0))

    def _platform(self, world: Element, centre: Floats) -> None:
        platform = SubElement(world, "body", name="platform", pos=_text(centre))
        for axis, direction in zip("xyz", np.eye(3), strict=True):
            SubElement(platform, "joint", name=f"platform_{axis}", type="slide", axis=_text(direction))
        radius = self.geometry.r
        _inertial(platform, self.m_p, [0, 0, 0], [self.m_p * radius**2 / 2] * 3)
        SubElement(
            platform, "geom", type="cylinder", size=_text([radius, 0.01]), mass="0", contype="0", conaffinity="0"
        )
        for number, phi in enumerate(self.geometry.phi, start=1):
            place = [radius * np.cos(phi), radius * np.sin(phi), 0.0]
            SubElement(platform, "site", name=f"platform_{number}", pos=_text(place))


def _added(model: Model) -> dict[str, Floats]:
    """What the effects add to the `BODIES` (3,), joint by joint."""
    structure = model.dynamics.structure
    added = {name: np.zeros(3) for name in BODIES}
    for index, term in enumerate(structure.terms):
        rows = [0, 1, 2] if term.effect.whole_robot else list(term.joints)
        values = structure.local_values(index, model.dynamics.values)
        for name, column in zip(term.effect.bodies or (), values.T, strict=False):
            added[name][rows] += column
    return added


def _inertial(body: Element, mass: float, place: Sequence[float], diagonal: Sequence[float]) -> None:
    least = TINY_MASS**2
    body.insert(
        0,
        Element(
            "inertial",
            mass=_text([mass]),
            pos=_text(place),
            diaginertia=_text([max(float(x), least) for x in diagonal]),
        ),
    )


def _bar(body: Element, length: float, colour: str) -> None:
    """What is seen of a body; its mass is in `inertial`."""
    SubElement(
        body, "geom", type="capsule", fromto=_text([0, 0, 0, length, 0, 0]), size="0.012", mass="0", contype="0",
        conaffinity="0", rgba=colour,
    )  # fmt: skip


def _quaternion(axis: str, angle: float) -> str:
    """Rotation about an axis, as MJCF writes it."""
    vector = np.sin(angle / 2) * np.eye(3)["xyz".index(axis)]
    return _text([np.cos(angle / 2), *vector])


def _text(values: Sequence[float] | Floats) -> str:
    return " ".join(repr(float(value)) for value in values)

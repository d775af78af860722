"""Torque of a tree of rigid links, linear in the links' inertial parameters, by Pinocchio.

The package is loaded when a chain is made.
"""

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ident.dynamics.closed_loops import ClosedLoops, closed_loops
from ident.dynamics.mimic_joints import MimicJoints, mimic_joints
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.urdf import Chain
from recordings.urdf_joints import robot_of

LINK_PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Inertial parameters of a link, in Pinocchio's order: mass [kg], first moments [kg m], inertia about the origin of
its frame [kg m^2]."""
_LIGHT = 1e-5
"""Share of the largest parameter below which a mass is too small: Pinocchio divides first moments by it."""
_KEPT = {"link": ("inertial",), "joint": ("parent", "child", "origin", "axis")}
"""What of a URDF is read; meshes and limits are not."""


@dataclass(frozen=True, eq=False)
class RigidChain:
    """A tree of links, each moved by one of N joints; dof of them are driven, and the others follow these."""

    model: Any
    """`pinocchio.Model` of these joints; others are fixed."""
    order: Ints
    """(N,) place of each joint among those of `model`: the driven ones, then those that follow."""
    tool: int
    """Frame of `model` that carries a payload."""
    followers: ClosedLoops | MimicJoints | None
    """How the other joints follow; None where all are driven."""

    def regressor(self, motion: Motion, kept: Ints | None = None) -> Floats:
        """Compute the torque (n, dof, k) per unit of each parameter of each link; NaN where a joint's motion is.

        Columns: `LINK_PARAMETERS` of the link that the first joint moves, then of the second; `kept`: (k,) those of
        the 10 N that are wanted, None: all.

        Raises:
            Unreachable: loops do not close at an instant.
        """
        import pinocchio

        compute = partial(pinocchio.computeJointTorqueRegressor, self.model, self.model.createData())
        places = (10 * self.order[:, None] + np.arange(10)).ravel()
        return self._along(motion, compute, len(places), places if kept is None else places[kept])

    def torque(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, dof) of links with these `parameters` (10 N,), in the order of the columns.

        The columns of all instants would take much more time and memory.
        """
        import pinocchio

        links, largest = parameters.reshape(-1, len(LINK_PARAMETERS)), float(np.abs(parameters).max())
        if (np.abs(links[:, 0]) < max(_LIGHT * largest, float(np.finfo(float).tiny))).any():
            masses = np.zeros_like(parameters)
            masses[:: len(LINK_PARAMETERS)] = 2 * largest or 1.0
            return self.torque(motion, parameters + masses) - self.torque(motion, masses)
        model = self.model.copy()
        for place, link in zip(self.order.tolist(), links, strict=True):
            model.inertias[place + 1] = pinocchio.Inertia.FromDynamicParameters(link)
        return replace(self, model=model).nominal_torque(motion)

    def nominal_torque(self, motion: Motion) -> Floats:
        """Compute the torque (n, dof) by the inertial values of the URDF, without friction."""
        import pinocchio

        return self._along(motion, partial(pinocchio.rnea, self.model, self.model.createData()))[:, :, 0]

    def kernel_rows(self, parameters: Floats) -> Floats:
        """Return (N, 22) for the compiled kernels: each joint's place in a tree, and the link that it moves.

        In Pinocchio's order, and in the directions of the base with all joints at 0: number of the parent's row from
        1, 0 for the base; number of the joint; 1 if it turns, 0 if it slides; its axis (3), its place beside its
        parent's (3) [m]; of the link about it mass, first (3) and second moments (9) [kg, kg m, kg m^2].

        parameters: (10 N,) of the links, in the order of the columns.
        """
        import pinocchio

        data, links = self.model.createData(), parameters.reshape(-1, len(LINK_PARAMETERS))
        pinocchio.forwardKinematics(self.model, data, np.zeros(self.model.nq))
        rows = []
        for number, joint in enumerate(np.argsort(self.order), start=1):
            parent, R, link = self.model.parents[number], data.oMi[number].rotation, links[joint]
            beside = data.oMi[number].translation - data.oMi[parent].translation
            inertia = link[[[4, 5, 7], [5, 6, 8], [7, 8, 9]]]
            second = R @ (np.trace(inertia) / 2 * np.eye(3) - inertia) @ R.T
            turns, axis = joint_motion(self, number)[3:].any(), R @ joint_axis(self, number)
            rows.append([parent, joint, turns, *axis, *beside, link[0], *(R @ link[1:4]), *second.ravel()])
        return np.array(rows, float)

    def with_gravity(self, gravity: Floats) -> "RigidChain":
        """Return the links under another `gravity` (3,) [m/s^2]."""
        model = self.model.copy()
        model.gravity.linear = gravity
        return replace(self, model=model)

    @property
    def nominal_parameters(self) -> Floats:
        """(10 N,) `LINK_PARAMETERS` of each link as the URDF has them, in the order of the columns."""
        inertias = list(self.model.inertias)[1:]
        return np.concatenate([inertias[place].toDynamicParameters() for place in self.order])

    @property
    def has_inertia(self) -> bool:
        """Whether the URDF has inertial values of moving links."""
        return any(inertia.mass > 0 for inertia in list(self.model.inertias)[1:])

    def mass_at(self, place: Sequence[float]) -> Floats:
        """(10 N,) `LINK_PARAMETERS` of 1 kg at a `place` (3,) [m] of the tool, in the order of the columns."""
        frame, links = self.model.frames[self.tool], np.zeros((len(self.order), len(LINK_PARAMETERS)))
        links[self.order == frame.parentJoint - 1] = point_mass(frame.placement.act(np.array(place)))
        return links.ravel()

    def random_motion(self, n: int) -> Motion:
        """Any `n` states of the driven joints; the same ones whenever it is called."""
        dof = len(self.order) if self.followers is None else len(self.followers.driven)
        position, *others = np.random.default_rng(0).uniform(-np.pi, np.pi, (4, n, dof))
        return Motion(position if self.followers is None else self.followers.wandering(position), *others)

    def _along(
        self, motion: Motion, compute: Callable[..., Floats], count: int = 1, kept: Ints | Sequence[int] = (0,)
    ) -> Floats:
        """Compute (n, dof, k) at the driven joints from each instant's motion in Pinocchio's order.

        compute: of position, velocity and acceleration (N,) of all joints, what acts on them (N, count), of which
            the columns `kept` (k,) are wanted.
        """
        signals = (motion.position, motion.velocity, motion.acceleration)
        known = np.flatnonzero(np.isfinite(np.concatenate(signals, axis=1)).all(axis=1))
        if self.followers:
            rows, S = self.followers.along(*signals)
        else:
            rows, S = [each[:, np.argsort(self.order)] for each in signals], None
        at_known = [np.ascontiguousarray(each[known]) for each in rows]
        computed = np.empty((len(known), len(self.order), count))
        for row, *at in zip(computed, *at_known, strict=True):
            row[:] = compute(*at).reshape(row.shape)  # of one joint or one column it is a vector
        result = np.full((*motion.position.shape, len(kept)), np.nan)
        if S is None:  # this takes a fraction of the time of `computed[:, :, kept]`
            places = count * self.order[:, None] + np.asarray(kept)
            result[known] = computed.reshape(len(known), count * len(self.order)).take(places, axis=1)
        else:
            result[known] = S[known].swapaxes(1, 2) @ computed[:, :, kept]
        return result


def joint_axis(links: RigidChain, number: int) -> Floats:
    """Axis (3,) of joint `number` of Pinocchio's model, in the frame of its link."""
    motion = joint_motion(links, number)
    return motion[:3] + motion[3:]  # of a prismatic or of a revolute joint


def joint_motion(links: RigidChain, number: int) -> Floats:
    """Velocity (3,) and angular velocity (3,) by a unit of joint `number`, in the frame of its link."""
    joint = links.model.joints[number]
    data = joint.createData()
    joint.calc(data, np.zeros(joint.nq))
    return np.asarray(data.S).ravel()


def point_mass(place: Sequence[float]) -> Floats:
    """Return the `LINK_PARAMETERS` of 1 kg at a `place` (3,) [m] of a link."""
    at = np.array(place, float)
    inertia = at @ at * np.eye(3) - np.outer(at, at)
    return np.concatenate([[1.0], at, inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])


def rigid_chain(chain: Chain) -> RigidChain:
    """Return the links and joints of `chain`.

    Raises:
        BadInput: Pinocchio or Clarabel is not installed.
    """
    for module, package in (("pinocchio", "pin"), ("clarabel", "clarabel")):
        if importlib.util.find_spec(module) is None:
            raise BadInput(
                f'the mechanism "urdf" needs the package {package}, which is not installed; install it with '
                "`pip install 'delta-workbench[urdf]'`"
            )
    return _built(chain.model_dump_json())


@lru_cache(maxsize=16)
def _built(described: str) -> RigidChain:
    import pinocchio

    chain = Chain.model_validate_json(described)
    model = pinocchio.buildModelFromXML(_plain(chain.urdf))
    position = np.zeros(model.nq)
    for name, value in chain.standing.items():
        position[model.idx_qs[model.getJointId(f"joint:{name}")]] = value
    names = [f"joint:{name}" for name in (*chain.joints, *chain.following)]
    others = [index for index in range(1, model.njoints) if model.names[index] not in names]
    model = pinocchio.buildReducedModel(model, others, position)
    model.gravity.linear = np.array(chain.gravity)
    order = np.array([model.idx_vs[model.getJointId(name)] for name in names])
    tool = model.getFrameId(f"link:{chain.tool}" if chain.tool else f"joint:{chain.joints[-1]}")
    if chain.payload and chain.payload.mass != "unknown":
        load, frame = chain.payload.mass * point_mass(chain.payload.place), model.frames[tool]
        model.appendBodyToJoint(frame.parentJoint, pinocchio.Inertia.FromDynamicParameters(load), frame.placement)
    if not chain.loops:
        return RigidChain(model, order, tool, mimic_joints(chain, order) if chain.following else None)
    start = np.zeros(model.nv)
    for name, value in chain.start.items():
        if f"joint:{name}" in names:
            start[model.idx_vs[model.getJointId(f"joint:{name}")]] = value
    driven, following = np.split(order, [len(chain.joints)])
    return RigidChain(model, order, tool, closed_loops(model, chain.loops, driven, following, start))


def _plain(text: str) -> str:
    """Return the URDF `text` with nothing but links and joints that have one coordinate each.

    Names become `link:NAME` and `joint:NAME`: Pinocchio keeps both in one list, with some of its own (`universe`).
    """
    robot = robot_of(text)
    robot.attrib = {"name": "robot"}  # without a name, or with a version that it does not know, it is refused
    for element in list(robot):
        if element.tag not in _KEPT:
            robot.remove(element)
            continue
        element.set("name", f"{element.tag}:{element.get('name')}")
        for part in list(element):
            if part.tag not in _KEPT[element.tag]:
                element.remove(part)
            elif part.tag in ("parent", "child"):
                part.set("link", f"link:{part.get('link')}")
        if element.tag == "joint" and element.get("type") != "fixed":
            # A continuous joint would have two coordinates, the cosine and the sine of its angle.
            element.set("type", "prismatic" if element.get("type") == "prismatic" else "revolute")
            ElementTree.SubElement(element, "limit", lower="-1", upper="1", effort="1", velocity="1")
    return ElementTree.tostring(robot, encoding="unicode")

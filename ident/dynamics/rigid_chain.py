"""Torque of a tree of rigid links, linear in the links' inertial parameters, by Pinocchio.

The package is loaded when a chain is made.
"""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.urdf import Chain

LINK_PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Inertial parameters of a link, in Pinocchio's order: mass [kg], first moments [kg m], inertia about the origin of
its frame [kg m^2]."""
_KEPT = {"link": ("inertial",), "joint": ("parent", "child", "origin", "axis")}
"""What of a URDF is read; meshes and limits are not."""


@dataclass(frozen=True, eq=False)
class RigidChain:
    """A tree of links, each moved by one of dof joints."""

    model: Any
    """`pinocchio.Model` of the driven joints; the others are fixed."""
    order: Ints
    """(dof,) place of each driven joint among those of `model`."""

    def regressor(self, motion: Motion) -> Floats:
        """Compute the torque (n, dof, 10 dof) per unit of each parameter of each link; NaN where a joint's motion is.

        Columns: `LINK_PARAMETERS` of the link that the first joint moves, then of the second.
        """
        import pinocchio

        data, dof = self.model.createData(), len(self.order)
        columns = (10 * self.order[:, None] + np.arange(10)).ravel()

        def torque(*at: Floats) -> Floats:
            computed: Floats = pinocchio.computeJointTorqueRegressor(self.model, data, *at)
            return computed

        return self._along(motion, torque, (dof, 10 * dof))[:, :, columns]

    def nominal_torque(self, motion: Motion) -> Floats:
        """Compute the torque (n, dof) by the inertial values of the URDF, without friction."""
        import pinocchio

        data = self.model.createData()
        return self._along(motion, lambda *at: pinocchio.rnea(self.model, data, *at), (len(self.order),))

    @property
    def has_inertia(self) -> bool:
        """Whether the URDF has inertial values of moving links."""
        return any(inertia.mass > 0 for inertia in list(self.model.inertias)[1:])

    def _along(self, motion: Motion, compute: Callable[..., Floats], shape: tuple[int, ...]) -> Floats:
        """Compute (n, *shape), the joints first among `shape`, from each instant's motion in Pinocchio's order."""
        signals = (motion.position, motion.velocity, motion.acceleration)
        known = np.flatnonzero(np.isfinite(np.concatenate(signals, axis=1)).all(axis=1))
        place = np.argsort(self.order)
        rows = [np.ascontiguousarray(signal[known][:, place]) for signal in signals]
        result = np.full((len(motion.position), *shape), np.nan)
        for instant, *at in zip(known, *rows, strict=True):
            result[instant] = compute(*at)
        return result[:, self.order]


def rigid_chain(chain: Chain) -> RigidChain:
    """Return the links and joints of `chain`.

    Raises:
        BadInput: Pinocchio is not installed.
    """
    if importlib.util.find_spec("pinocchio") is None:
        raise BadInput(
            'the mechanism "urdf" needs the package pin, which is not installed; install it with '
            "`pip install 'delta-workbench[urdf]'`"
        )
    return _built(chain.model_dump_json())


@lru_cache(maxsize=16)
def _built(described: str) -> RigidChain:
    import pinocchio

    chain = Chain.model_validate_json(described)
    model = pinocchio.buildModelFromXML(_plain(chain.urdf))
    position = np.zeros(model.nq)
    for name, value in chain.fixed.items():
        position[model.idx_qs[model.getJointId(name)]] = value
    others = [index for index in range(1, model.njoints) if model.names[index] not in chain.joints]
    model = pinocchio.buildReducedModel(model, others, position)
    model.gravity.linear = np.array(chain.gravity)
    if chain.payload:
        load = pinocchio.Inertia(chain.payload.mass, np.array(chain.payload.com), np.zeros((3, 3)))
        model.appendBodyToJoint(model.getJointId(chain.joints[-1]), load, pinocchio.SE3.Identity())
    order = np.array([model.idx_vs[model.getJointId(name)] for name in chain.joints])
    return RigidChain(model, order)


def _plain(text: str) -> str:
    """Return the URDF `text` with nothing but links and joints that have one coordinate each."""
    robot = ElementTree.fromstring(text)
    for element in list(robot):
        if element.tag not in _KEPT:
            robot.remove(element)
            continue
        for part in list(element):
            if part.tag not in _KEPT[element.tag]:
                element.remove(part)
        if element.tag == "joint" and element.get("type") != "fixed":
            # A continuous joint would have two coordinates, the cosine and the sine of its angle.
            element.set("type", "prismatic" if element.get("type") == "prismatic" else "revolute")
            ElementTree.SubElement(element, "limit", lower="-1", upper="1", effort="1", velocity="1")
    return ElementTree.tostring(robot, encoding="unicode")

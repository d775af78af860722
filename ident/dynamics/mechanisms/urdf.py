"""Any tree of links: base parameters of its URDF, friction and offset of each joint.

    effort = W(q, q', q'') p + C' (c_v w + c_c sgn w) + c_o,    w = C q'

W are the columns of the base parameters p, among them those of the motors, whose inertia acts at w' = C q''. C is the
unit matrix, but for motors that turn with another joint (`couplings`). Friction is positive where it opposes motion.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ident.dynamics.base_parameters import BaseParameters, base_parameters
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.motion import Motion
from ident.dynamics.rigid_chain import LINK_PARAMETERS, RigidChain, rigid_chain
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Chain

_STATES = 100
"""Random states that tell on which parameters the torque depends: many times more rows than parameters."""


def create(rig: Rig) -> "Urdf":
    """Create the tree of links described by `rig`.

    Raises:
        BadInput: Pinocchio is not installed.
    """
    return _created(rig.chain.model_dump_json())


@lru_cache(maxsize=16)
def _created(described: str) -> "Urdf":
    chain = Chain.model_validate_json(described)
    links = rigid_chain(chain)
    generator = np.random.default_rng(0)  # any states do; the same ones give the same names
    states = Motion(*generator.uniform(-np.pi, np.pi, (4, _STATES, len(chain.joints))))
    columns = _physical_columns(chain, links, states)
    return Urdf(chain, links, base_parameters(columns.reshape(-1, columns.shape[2])))


@dataclass(frozen=True, eq=False)
class Urdf:
    """A tree of links with dof driven joints."""

    chain: Chain
    links: RigidChain
    base: BaseParameters

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Base parameters, then viscous and Coulomb friction and offset of all joints."""
        physical = _physical_parameters(self.chain)
        names = [parameter.name for parameter in physical]
        base = []
        for index, column in enumerate(self.base.columns):
            alone = np.count_nonzero(self.base.combination[index]) == 1
            parameter = physical[column]
            base.append(
                parameter
                if alone
                else replace(
                    parameter, name=f"{parameter.name}+", meaning=self.base.sum_of(index, names), nonnegative=False
                )
            )
        return (*base, *_joint_parameters(self.chain))

    def regressor(self, motion: Motion) -> Floats:
        """Compute the columns (n, dof, k), in the order of `parameters`."""
        rigid = _physical_columns(self.chain, self.links, motion)[:, :, self.base.columns]
        C = _motor_matrix(self.chain)
        speed = motion.velocity @ C.T
        friction = (_of_motors(C, speed), _of_motors(C, _direction(motion, C, speed)))
        offset = np.broadcast_to(np.eye(len(C)), friction[0].shape)
        return np.concatenate([rigid, *friction, offset], axis=2)

    def inertia(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the inertia matrix (n, dof, dof) [kg m^2, kg m or kg]."""
        still = np.zeros_like(motion.position)
        at_rest = self._rigid(motion, still, parameters)
        columns = [self._rigid(motion, still + unit, parameters) - at_rest for unit in np.eye(still.shape[1])]
        return np.stack(columns, axis=2)

    def gravity(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, dof) [N m or N] that holds the links at rest, with the offset."""
        return self._rigid(motion, np.zeros_like(motion.position), parameters)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """Compute the torque (n, dof) by the inertial values of the URDF; None if it has none."""
        return self.links.nominal_torque(motion) if self.links.has_inertia else None

    def _rigid(self, motion: Motion, acceleration: Floats, parameters: Floats) -> Floats:
        """Torque (n, dof) of links and motors that start to move with the `acceleration` (n, dof)."""
        still = np.zeros_like(motion.position)
        start = Motion(motion.position, still, acceleration, still)
        torque: Floats = np.einsum("njk,k->nj", self.regressor(start), parameters)
        return torque


def _physical_parameters(chain: Chain) -> list[Parameter]:
    """Ten parameters of each link, then the inertia of each motor."""
    links = [
        Parameter(
            f"{name}_{link}",
            "kg" if name == "m" else "kg m" if name.startswith("m") else "kg m^2",
            f"{name} of the link that joint {link} moves",
        )
        for link in range(1, len(chain.joints) + 1)
        for name in LINK_PARAMETERS
    ]
    motors = [
        Parameter(f"Im_{i}", _units(kind)[2], f"inertia of the motor of joint {i}, at the joint", nonnegative=True)
        for i, kind in enumerate(chain.types, start=1)
    ]
    return [*links, *(motors if chain.motor_inertia else ())]


def _joint_parameters(chain: Chain) -> list[Parameter]:
    """Viscous and Coulomb friction and offset of each joint."""
    joints = [(i, *_units(kind)) for i, kind in enumerate(chain.types, start=1)]
    return [
        *(
            Parameter(f"c_v{i}", f"{effort} s/{position}", f"viscous friction of joint {i}", friction=True)
            for i, position, effort, _ in joints
        ),
        *(
            Parameter(f"c_c{i}", effort, f"Coulomb friction of joint {i}", friction=True)
            for i, _, effort, _ in joints
        ),
        *(Parameter(f"c_o{i}", effort, f"constant torque of joint {i}") for i, _, effort, _ in joints),
    ]


def _units(kind: str) -> tuple[str, str, str]:
    """Units of position, effort and inertia of a kind of joint."""
    return ("rad", "N m", "kg m^2") if kind == "revolute" else ("m", "N", "kg")


def _physical_columns(chain: Chain, links: RigidChain, motion: Motion) -> Floats:
    """Torque (n, dof, k) per unit of each of `_physical_parameters`."""
    columns = [links.regressor(motion)]
    if chain.motor_inertia:
        C = _motor_matrix(chain)
        columns.append(_of_motors(C, motion.acceleration @ C.T))
    return np.concatenate(columns, axis=2)


def _motor_matrix(chain: Chain) -> Floats:
    """C (dof, dof): motions of the motors, counted at their joints, of those of the joints."""
    C = np.eye(len(chain.joints))
    for coupling in chain.couplings:
        C[coupling.of - 1, coupling.by - 1] += coupling.ratio
    return C


def _of_motors(C: Floats, signal: Floats) -> Floats:
    """Torque (n, dof, dof) on the joints per unit of each motor's coefficient of its `signal` (n, dof)."""
    columns: Floats = signal[:, None, :] * C.T
    return columns


def _direction(motion: Motion, C: Floats, speed: Floats) -> Floats:
    """Compute sgn (n, dof) of the motors' `speed`, averaged over a sample in which one reverses."""
    coupled = np.count_nonzero(C, axis=1) > 1
    sweep = np.abs(motion.sweep @ C.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        averaged = np.where(np.abs(speed) < sweep, speed / sweep, np.sign(speed))
    return np.where(coupled, averaged, motion.direction)

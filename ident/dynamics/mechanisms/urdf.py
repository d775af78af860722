"""Any tree of links, loops closed or not: base parameters of its URDF, friction and offset of each joint.

    effort = W(q, q', q'') p + C' (c_v w + c_c sgn w) + c_o,    w = C q'

W are the columns of the base parameters p, among them those of the motors, whose inertia acts at w' = C q''. C is the
unit matrix, but for motors that turn with another joint (`couplings`). Friction is positive where it opposes motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ident.dynamics.base_parameters import BaseParameters, base_parameters
from ident.dynamics.bodies import nearest_bodies
from ident.dynamics.mechanisms import Parameter, friction_parameters, units
from ident.dynamics.motion import Motion, inertia_matrix
from ident.dynamics.rigid_chain import LINK_PARAMETERS, RigidChain, rigid_chain
from recordings.recording import Bools, Floats, Ints
from recordings.rig import Rig
from recordings.urdf import Chain, Vector

_ZERO_ERROR = 0.01
"""Of an encoder, to see whether it changes more than parameters [rad or m]."""
_VISIBLE = 1e-6
"""Share of the columns that an error of the zero changes beyond any parameters; rounding leaves 1e-12."""
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
    every = np.arange(len(_physical_parameters(chain)))
    columns = np.concatenate(_physical_columns(chain, links, links.random_motion(_STATES), every), axis=2)
    return Urdf(chain, links, base_parameters(columns.reshape(-1, columns.shape[2])))


@dataclass(frozen=True, eq=False)
class Urdf:
    """A tree of links with dof driven joints."""

    chain: Chain
    links: RigidChain
    base: BaseParameters
    bound_to_bodies: bool = False
    """Whether fits allow only base parameters that bodies have."""

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
        kinds = self.chain.types
        offsets = [
            Parameter(f"c_o{i}", units(kind)[1], f"constant torque of joint {i}") for i, kind in enumerate(kinds, 1)
        ]
        return (*base, *friction_parameters(kinds), *offsets)

    def regressor(self, motion: Motion) -> Floats:
        """Compute the columns (n, dof, k), in the order of `parameters`."""
        rigid = _physical_columns(self.chain, self.links, motion, self.base.columns)
        C = motor_matrix(self.chain)
        speed = motion.velocity @ C.T
        friction = (_of_motors(C, speed), _of_motors(C, _direction(motion, C, speed)))
        offset = np.broadcast_to(np.eye(len(C)), friction[0].shape)
        return np.concatenate([*rigid, *friction, offset], axis=2)

    def torque(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, dof) of the `parameters` (k,), in less time and memory than by the columns."""
        C = motor_matrix(self.chain)
        links, motors = np.split(self.physical_parameters(parameters), [self.links.nominal_parameters.size])
        viscous, coulomb, offset = np.split(parameters[len(self.base.columns) :], 3)
        speed = motion.velocity @ C.T
        of_motors = viscous * speed + coulomb * _direction(motion, C, speed)
        if len(motors):
            of_motors += motors * (motion.acceleration @ C.T)
        return self.links.torque(motion, links) + of_motors @ C + offset

    def kernel_constants(self, parameters: Floats, beyond: Sequence[tuple[float, Vector]] = ()) -> Floats:
        """Return motors, offsets, gravity and links with the `parameters` (k,), as `link_kernels` take them.

        beyond: masses [kg] and their places [m] on the tool beyond the payload.
        """
        C, dof = motor_matrix(self.chain), len(self.chain.joints)
        links, motors = np.split(self.physical_parameters(parameters), [self.links.nominal_parameters.size])
        inertia = C.T * motors @ C if len(motors) else np.zeros((dof, dof))
        rows = self.links.kernel_rows(self._loaded(links, beyond))
        return np.concatenate([inertia.ravel(), parameters[-dof:], self.chain.gravity, rows.ravel()])

    def inertia(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the inertia matrix (n, dof, dof) [kg m^2, kg m or kg]."""
        return inertia_matrix(lambda at: self.torque(at, parameters), motion.position)

    def gravity(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, dof) [N m or N] that holds the links at rest, with the offset."""
        still = np.zeros_like(motion.position)
        return self.torque(Motion(motion.position, still, still, still), parameters)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """Compute the torque (n, dof) by the inertial values of the URDF; None if it has none."""
        return self.links.nominal_torque(motion) if self.links.has_inertia else None

    def torque_per_mass(self, motion: Motion, place: Vector) -> Floats:
        """Compute the torque (n, dof) [N m/kg or N/kg] of 1 kg at a `place` of the tool's link."""
        return self.links.torque(motion, self.links.mass_at(place))

    def physical_parameters(self, parameters: Floats) -> Floats:
        """(k,) parameters of links and motors that have the base `parameters`: those nearest to the URDF's."""
        known = self.known_parameters
        return known + self._inverse @ (parameters[: len(self.base.columns)] - self.base.combination @ known)

    @property
    def known_parameters(self) -> Floats:
        """(k,) physical parameters of links as the URDF has them, and motors without inertia."""
        known = np.zeros(self.base.combination.shape[1])
        known[: self.links.nominal_parameters.size] = self.links.nominal_parameters
        return known

    def nearest_bodies(self, root: Floats, target: Floats, least: Floats | None = None) -> Floats:
        """(k,) physical parameters of bodies: `root` (r, b) times their base parameters is nearest to `target` (r,).

        least: as in `bodies.nearest_bodies`.
        """
        links = self.links.nominal_parameters.size // len(LINK_PARAMETERS)
        return nearest_bodies(root @ self.base.combination, target, self.known_parameters, links, least)

    @cached_property
    def _inverse(self) -> Floats:
        """(k, b) smallest physical parameters per unit of each base parameter."""
        return np.asarray(np.linalg.pinv(self.base.combination), np.float64)

    def sideways(self, motion: Motion, parameters: Floats, beyond: Sequence[tuple[float, Vector]] = ()) -> Floats:
        """Compute the torque (n, dof, 2) per unit of gravity in the two directions across the stated one.

        Of a tree under gravity along -z they are x and y. A tilt shows more of the links than the base parameters
        tell, such as the first moments of a link that turns about a vertical axis: those are the URDF's.

        beyond: masses [kg] and their places [m] on the tool beyond the payload.
        """
        still = np.zeros_like(motion.position)
        start = replace(motion, velocity=still, acceleration=still)
        links = self._loaded(self.physical_parameters(parameters)[: self.links.nominal_parameters.size], beyond)
        return np.stack([self.links.with_gravity(e).torque(start, links) for e in self.across], axis=2)

    def _loaded(self, links: Floats, beyond: Sequence[tuple[float, Vector]]) -> Floats:
        """Parameters (10 N,) of `links` that carry masses [kg] at places [m] of the tool."""
        return links + sum((mass * self.links.mass_at(place) for mass, place in beyond), start=np.zeros_like(links))

    @property
    def across(self) -> Floats:
        """Two unit vectors (2, 3) across gravity: x and y where it is along -z; any two where there is none."""
        gravity = np.array(self.chain.gravity)
        up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])
        axis = np.eye(3)[np.argmin(np.abs(up))]
        first = axis - axis @ up * up
        first /= np.linalg.norm(first)
        return np.array([first, np.cross(up, first)])

    @cached_property
    def visible_zeros(self) -> Bools:
        """(dof,) whether other base parameters do not replace another zero of the joint's encoder."""
        states = self.links.random_motion(_STATES)
        shown = []
        for unit in np.eye(len(self.chain.joints)):
            moved = replace(states, position=states.position + _ZERO_ERROR * unit)
            here, there = (
                self.regressor(at)[:, :, : len(self.base.columns)].reshape(-1, len(self.base.columns))
                for at in (states, moved)
            )
            rest = there - here @ np.linalg.lstsq(here, there, rcond=None)[0]
            shown.append(np.linalg.norm(rest) > _VISIBLE * np.linalg.norm(there))
        return np.array(shown)


def _physical_parameters(chain: Chain) -> list[Parameter]:
    """Ten parameters of each link, then the inertia of each motor."""
    joints = [*map(str, range(1, len(chain.joints) + 1)), *chain.following]
    links = [
        Parameter(
            f"{name}_{link}",
            "kg" if name == "m" else "kg m" if name.startswith("m") else "kg m^2",
            f"{name} of the link that joint {joint} moves",
        )
        for link, joint in enumerate(joints, start=1)
        for name in LINK_PARAMETERS
    ]
    motors = [
        Parameter(f"Im_{i}", units(kind)[2], f"inertia of the motor of joint {i}, at the joint", nonnegative=True)
        for i, kind in enumerate(chain.types, start=1)
    ]
    return [*links, *(motors if chain.motor_inertia else ())]


def _physical_columns(chain: Chain, links: RigidChain, motion: Motion, kept: Ints) -> list[Floats]:
    """Torque (n, dof, k) per unit of the `kept` (k,) ones of `_physical_parameters`: of links, then of motors."""
    of_links, of_motors = np.split(kept, np.searchsorted(kept, [links.nominal_parameters.size]))
    C = motor_matrix(chain)
    motors = _of_motors(C, motion.acceleration @ C.T)[:, :, of_motors - links.nominal_parameters.size]
    return [links.regressor(motion, of_links), motors]


def motor_matrix(chain: Chain) -> Floats:
    """C (dof, dof): motions of the motors, counted at their joints, of those of the joints."""
    C = np.eye(len(chain.joints))
    for coupling in chain.couplings:
        C[coupling.of - 1, coupling.by - 1] += coupling.ratio
    return C


def _of_motors(C: Floats, signal: Floats) -> Floats:
    """Torque (n, dof, dof) on the joints per unit of each motor's coefficient of its `signal` (n, dof)."""
    return signal[:, None, :] * C.T


def _direction(motion: Motion, C: Floats, speed: Floats) -> Floats:
    """Compute sgn (n, dof) of the motors' `speed`, averaged over a sample in which one reverses."""
    coupled = np.count_nonzero(C, axis=1) > 1
    sweep = np.abs(motion.sweep @ C.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        averaged = np.where(np.abs(speed) < sweep, speed / sweep, np.sign(speed))
    return np.where(coupled, averaged, motion.direction)

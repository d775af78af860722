"""Inverse dynamics with hidden effects: from a prescribed motion to the reported positions and voltages."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import convolve1d

from drivers.simulated.effect import HiddenEffect
from recordings.recording import Floats
from recordings.rig import Geometry
from tests.drivers.simulated.exact_delta import exact_torque
from tests.foreign import balls, beyond_library, couplings, laws, out_of_library
from tests.foreign.reference_motion import ReferenceMotion
from tests.foreign.robots import Robot
from trajectories import kinematics

KINDS = out_of_library.KINDS | beyond_library.KINDS
"""Effects of this plant alone, by name."""
_G = 9.81
_PICK_UP_TIME = 0.05
"""Duration of picking up a load [s]."""
_MAX_VOLTAGE_SHARE = 0.995
"""Largest voltage relative to the amplifier's limit."""
_LINEARIZATION_STEP = 8
"""Instants of the fine grid per linearization of the dynamics."""
_DIFFERENCE = 1e-4
"""Step of the finite differences for the linearization [rad, rad/s]."""


@dataclass(frozen=True, eq=False)
class Reported:
    """Signals that drives with perfect sensors report, once per sample."""

    position: Floats
    """(m, 3) [rad]."""
    velocity: Floats
    """(m, 3) derivative of the position [rad/s]."""
    acceleration: Floats
    voltage: Floats
    """(m, 3) [V]."""


def name(effect: HiddenEffect) -> str:
    """Name of an effect of the list or of this plant."""
    return next((name for name, kind in KINDS.items() if isinstance(effect, kind)), effect.name())


class Plant:
    """A robot that follows one reference motion."""

    def __init__(self, robot: Robot, reference: ReferenceMotion) -> None:
        self.robot, self.reference = robot, reference

    def report(self, effects: Sequence[HiddenEffect] = ()) -> Reported:
        """Signals that are reported with the hidden `effects`.

        Raises:
            Unreachable: the robot with its actual lengths cannot follow the motion.
        """
        reference = self.reference
        hidden = _Hidden(effects)
        load = self._arm_torque(hidden)
        lead, coupling_torque = self._coupled(hidden, load)
        q = reference.theta[reference.rows] + lead
        moved = bool(lead.any())
        v = np.gradient(q, reference.step, axis=0) if moved else reference.rate[reference.rows]
        a = np.gradient(v, reference.step, axis=0) if moved else reference.acceleration[reference.rows]
        torque = coupling_torque + self._motor_torque(hidden, q, v, a, load)
        torque = self._advanced(torque, hidden)
        reported_position = q + _encoder_error(hidden, q)
        reported_velocity = np.gradient(reported_position, reference.step, axis=0)
        reported_acceleration = np.gradient(reported_velocity, reference.step, axis=0)
        sampled = slice(None, None, reference.per_sample)
        volts = self._volts(self._averaged(torque), v[sampled], hidden)
        return Reported(reported_position[sampled], reported_velocity[sampled], reported_acceleration[sampled], volts)

    # The arms

    def _arm_torque(self, hidden: "_Hidden") -> Floats:
        """(n, 3) torque of the arms, without motors and friction, if they follow the motion exactly."""
        reference = self.reference
        geometry, gravity = hidden.geometry(self.robot.rig.geometry), hidden.gravity()
        nominal = geometry == self.robot.rig.geometry and gravity == (0.0, 0.0, -_G)
        unique = self._level_torque if nominal else self._rigid(geometry, gravity)
        torque = unique[reference.rows]
        for _, p in hidden.of("air_drag"):
            torque = torque + p["c"] * self._drag_torque[reference.rows]
        for _, p in hidden.of("passive_joint_friction"):
            dry, viscous = self._ball_torques
            torque = torque + p["mu"] * (dry + p["viscous"] * viscous)[reference.rows]
        for _, p in hidden.of("payload_change"):
            torque = (
                torque
                + p["dm"] * self._load_share(p["t_c"], p["t_e"])[:, None] * self._torque_per_mass[reference.rows]
            )
        q = reference.theta[reference.rows]
        state = self._state(q, q, q, torque)
        return torque + hidden.sum(laws.ARM, state)

    def _rigid(self, geometry: Geometry, gravity: tuple[float, float, float]) -> Floats:
        """(u, 3) rigid-body torque without the motors' inertia."""
        reference = self.reference
        links = self.robot.links.model_copy(update={"motor_inertia": 0.0})
        return exact_torque(geometry, links, reference.theta, reference.rate, reference.acceleration, gravity)

    @cached_property
    def _level_torque(self) -> Floats:
        return self._rigid(self.robot.rig.geometry, (0.0, 0.0, -_G))

    @cached_property
    def _torque_per_mass(self) -> Floats:
        """(u, 3) additional rigid-body torque per kg on the platform."""
        reference, links = self.reference, self.robot.links.model_copy(update={"motor_inertia": 0.0})
        links = links.model_copy(update={"payload": links.payload + 1.0})
        heavier = exact_torque(
            self.robot.rig.geometry, links, reference.theta, reference.rate, reference.acceleration
        )
        return heavier - self._level_torque

    @cached_property
    def _drag_torque(self) -> Floats:
        """(u, 3) torque of air drag with unit coefficient: J' |P'| P'."""
        reference = self.reference
        motion = (reference.theta, reference.rate, reference.acceleration)
        J = kinematics.platform_motion(self.robot.rig.geometry, *motion)[3]
        force = np.linalg.norm(reference.platform_rate, axis=1)[:, None] * reference.platform_rate
        torque: Floats = np.einsum("nij,ni->nj", J, force)
        return torque

    @cached_property
    def _ball_torques(self) -> Floats:
        """(2, u, 3) torque of unit dry and of unit viscous friction of the balls."""
        return balls.ball_torques(self.robot.rig.geometry, self.reference.theta, self.reference.rate)

    def _load_share(self, start: float, end: float) -> Floats:
        """(n,) share of the load on the platform, 0 to 1."""
        time = self.reference.time
        up, down = (np.clip((time - instant) / _PICK_UP_TIME + 0.5, 0.0, 1.0) for instant in (start, end))
        return up - down

    # Between arm and motor

    def _coupled(self, hidden: "_Hidden", load: Floats) -> tuple[Floats, Floats]:
        """Angle (n, 3) by which the motors lead the motion, and torque (n, 3) between motors and arms."""
        twist, half = np.zeros_like(load), np.zeros(3)
        for mask, p in hidden.of("joint_elasticity"):
            # The arms follow the motion exactly; the motors lead by the deflection of the springs.
            twist += mask * p["compliance"] * load
        for mask, p in hidden.of("backlash"):
            half += mask * p["b"]
        if not half.any():
            return twist, load
        # The motors follow the motion exactly; the arms move within the gap.
        return twist, couplings.backlash_torque(
            np.ascontiguousarray(load), self._linearized, half, self.reference.step
        )

    @cached_property
    def _linearized(self) -> couplings.Linear:
        reference = self.reference
        sampled = reference.rows[::_LINEARIZATION_STEP]
        unique_rows, inverse = np.unique(sampled, return_inverse=True)
        theta, rate = reference.theta[unique_rows], reference.rate[unique_rows]
        acceleration = reference.acceleration[unique_rows]
        geometry, links = self.robot.rig.geometry, self.robot.links.model_copy(update={"motor_inertia": 0.0})

        def derivative(vary: Callable[[Floats], tuple[Floats, Floats, Floats]]) -> Floats:
            """Derivative (m, 3, 3) of the torque by the varied quantity."""
            torques = [
                [exact_torque(geometry, links, *vary(sign * _DIFFERENCE * e)) for e in np.eye(3)] for sign in (1, -1)
            ]
            slope: Floats = np.stack(
                [(up - down) / (2 * _DIFFERENCE) for up, down in zip(*torques, strict=True)], axis=2
            )
            return slope[inverse]

        return couplings.Linear(
            inertia=derivative(lambda e: (theta, rate, acceleration + e * 1e4)) / 1e4,
            damping=derivative(lambda e: (theta, rate + e, acceleration)),
            stiffness=derivative(lambda e: (theta + e, rate, acceleration)),
            every=_LINEARIZATION_STEP,
        )

    # The motors

    def _state(self, q: Floats, v: Floats, a: Floats, load: Floats) -> laws.State:
        friction = self.robot.friction
        coulomb, viscous = np.array(friction.coulomb), np.array(friction.viscous)
        return laws.State(self.reference.time[:, None], q, v, a, load, coulomb, viscous)

    def _motor_torque(self, hidden: "_Hidden", q: Floats, v: Floats, a: Floats, load: Floats) -> Floats:
        """(n, 3) torque of the inertia, friction and hidden effects of the motors."""
        friction, links = self.robot.friction, self.robot.links
        state = self._state(q, v, a, load + links.motor_inertia * a)
        motor_torque = links.motor_inertia * a + friction.viscous * v + state.coulomb * state.direction
        for effect in hidden.effects:
            if (law := name(effect)) in beyond_library.LAWS:
                motor_torque = motor_torque + _mask(effect) * beyond_library.torque(law, effect, state)
        return motor_torque + hidden.sum(laws.MOTOR, state)

    def _advanced(self, torque: Floats, hidden: "_Hidden") -> Floats:
        """Torque (n, 3) that corresponds to the voltage: with an actuation delay, the torque of a later instant."""
        delays = sum((mask * p["delay"] for mask, p in hidden.of("actuation_delay")), np.zeros(3))
        if not delays.any():
            return torque
        time = self.reference.time
        return np.column_stack(
            [np.interp(time + delay, time, shifted) for delay, shifted in zip(delays, torque.T, strict=True)]
        )

    def _averaged(self, torque: Floats) -> Floats:
        """(m, 3) mean over a sampling period around each sample."""
        window = self.reference.per_sample
        weights = np.r_[0.5, np.ones(window - 1), 0.5] / window
        averaged: Floats = convolve1d(torque, weights, axis=0, mode="nearest")[::window]
        return averaged

    # Drives and sensors

    def _volts(self, torque: Floats, v: Floats, hidden: "_Hidden") -> Floats:
        """(m, 3) reported voltages for the `torque` at the speed v (m, 3)."""
        rig = self.robot.rig
        gain, exponent = np.array(rig.torque.gain), 2.0 if rig.torque.map == "square" else 1.0
        gain = gain * (1 + sum((mask * p["mismatch"] for mask, p in hidden.of("torque_gain_mismatch")), np.zeros(3)))
        power = exponent + sum((mask * p["excess"] for mask, p in hidden.of("torque_map_exponent")), np.zeros(3))
        volts = np.sign(torque) * np.abs(torque / gain) ** (1 / power)
        if rig.drives[0].voltage.kind == "command":
            for mask, p in hidden.of("amplifier_saturation"):
                used = np.minimum(np.abs(volts) * p["inverse_level"], _MAX_VOLTAGE_SHARE)
                volts = np.where(mask, volts / (1 - used ** p["n"]) ** (1 / p["n"]), volts)
            for mask, p in hidden.of("amplifier_deadband"):
                volts = volts + mask * p["width"] * np.sign(volts)
        for mask, p in hidden.of("back_emf"):
            volts = volts + mask * p["k_e"] * v
        reported: Floats = volts
        return reported


class _Hidden:
    """Hidden effects, with look-up by name."""

    def __init__(self, effects: Sequence[HiddenEffect]) -> None:
        self.effects = effects

    def of(self, wanted: str) -> Iterator[tuple[Floats, laws.Parameters]]:
        """Mask (3,) of joints, 0 or 1, and parameters of each effect with the name `wanted`."""
        for effect in self.effects:
            if name(effect) == wanted:
                yield _mask(effect), _parameters(effect)

    def sum(self, laws_by_name: dict[str, laws.Law], state: laws.State) -> Floats:
        """(n, 3) total torque of the effects that have a law in `laws_by_name`."""
        torque = np.zeros_like(state.q)
        for effect in self.effects:
            if name(effect) in laws_by_name:
                torque += _mask(effect) * laws_by_name[name(effect)](state, _parameters(effect))
        return torque

    def geometry(self, geometry: Geometry) -> Geometry:
        """Actual geometry of the robot."""
        for _, p in self.of("geometry_error"):
            lengths = {
                length: getattr(geometry, length) + p["error"] * p[length] for length in ("L1", "L2", "R", "r")
            }
            geometry = geometry.model_copy(update=lengths)
        return geometry

    def gravity(self) -> tuple[float, float, float]:
        """Gravity in the frame of the base [m/s^2]."""
        x, y, z = 0.0, 0.0, -_G
        for _, p in self.of("base_tilt"):
            horizontal, z = _G * np.sin(p["angle"]), -_G * float(np.cos(p["angle"]))
            x, y = float(horizontal * np.cos(p["direction"])), float(horizontal * np.sin(p["direction"]))
        return x, y, z


def _encoder_error(hidden: _Hidden, q: Floats) -> Floats:
    error = np.zeros_like(q)
    for mask, p in hidden.of("encoder_zero_offset"):
        error += mask * p["c"]
    for mask, p in hidden.of("encoder_eccentricity"):
        error += mask * p["a"] * np.sin(p["N"] * q + p["phase"])
    return error


def _mask(effect: HiddenEffect) -> Floats:
    return np.array([1.0 if joint in effect.joints else 0.0 for joint in (1, 2, 3)])


def _parameters(effect: HiddenEffect) -> laws.Parameters:
    return effect.model_dump(exclude={"joints"})

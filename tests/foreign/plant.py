"""From a prescribed motion to what the drives would report of it: inverse dynamics, effect by effect."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import convolve1d

from drivers.simulated.effect import HiddenEffect
from recordings.recording import Floats
from recordings.rig import Geometry
from tests.drivers.simulated.exact_delta import exact_torque
from tests.foreign import couplings, laws, outside
from tests.foreign.courses import ReferenceMotion
from tests.foreign.robots import Robot
from trajectories import kinematics

_G = 9.81
_PICK_UP = 0.05
"""How long it takes until a load is picked up [s]."""
_FULL = 0.995
"""Nearest that a voltage comes to the amplifier's highest one, relative."""
_COARSE = 8
"""Instants of the fine grid between two at which the dynamics are made linear."""
_SMALL = 1e-4
"""Differences for that [rad, rad/s]."""


@dataclass(frozen=True, eq=False)
class Reported:
    """What the drives would report with perfect sensors, once per sample."""

    position: Floats
    """(m, 3) [rad]."""
    velocity: Floats
    """(m, 3) of that position."""
    acceleration: Floats
    voltage: Floats
    """(m, 3) [V]."""


def name(effect: HiddenEffect) -> str:
    """Of an effect of the list, or of those of this plant."""
    return next((name for name, kind in outside.KINDS.items() if isinstance(effect, kind)), effect.name())


class Plant:
    """One robot on one course."""

    def __init__(self, robot: Robot, course: ReferenceMotion) -> None:
        self.robot, self.course = robot, course

    def report(self, effects: Sequence[HiddenEffect] = ()) -> Reported:
        """What is reported with these effects.

        Raises:
            Unreachable: the robot, as long as it really is, cannot follow the course.
        """
        course = self.course
        hidden = _Hidden(effects)
        load = self._arm_torque(hidden)
        twisted, teeth = self._coupled(hidden, load)
        q = course.theta[course.rows] + twisted
        moved = bool(twisted.any())
        v = np.gradient(q, course.step, axis=0) if moved else course.rate[course.rows]
        a = np.gradient(v, course.step, axis=0) if moved else course.acceleration[course.rows]
        torque = teeth + self._motor_torque(hidden, q, v, a, load)
        torque = self._ahead(torque, hidden)
        read = q + _encoder_error(hidden, q)
        seen_v = np.gradient(read, course.step, axis=0)
        seen_a = np.gradient(seen_v, course.step, axis=0)
        once = slice(None, None, course.per_sample)
        volts = self._volts(self._averaged(torque), v[once], hidden)
        return Reported(read[once], seen_v[once], seen_a[once], volts)

    # The arms

    def _arm_torque(self, hidden: "_Hidden") -> Floats:
        """(n, 3) that the arms take, without motors and friction, if they follow the course exactly."""
        course = self.course
        geometry, gravity = hidden.geometry(self.robot.rig.geometry), hidden.gravity()
        plain = geometry == self.robot.rig.geometry and gravity == (0.0, 0.0, -_G)
        unique = self._level if plain else self._rigid(geometry, gravity)
        torque = unique[course.rows]
        for _, p in hidden.of("air_drag"):
            torque = torque + p["c"] * self._drag[course.rows]
        for _, p in hidden.of("payload_change"):
            torque = torque + p["dm"] * self._held(p["t_c"], p["t_e"])[:, None] * self._per_mass[course.rows]
        q = course.theta[course.rows]
        state = self._state(q, q, q, torque)
        return torque + hidden.sum(laws.ARM, state)

    def _rigid(self, geometry: Geometry, gravity: tuple[float, float, float]) -> Floats:
        """(u, 3) without the motors' inertia."""
        course = self.course
        links = self.robot.links.model_copy(update={"motor_inertia": 0.0})
        return exact_torque(geometry, links, course.theta, course.rate, course.acceleration, gravity)

    @cached_property
    def _level(self) -> Floats:
        return self._rigid(self.robot.rig.geometry, (0.0, 0.0, -_G))

    @cached_property
    def _per_mass(self) -> Floats:
        """(u, 3) more of it for each kg on the platform."""
        course, links = self.course, self.robot.links.model_copy(update={"motor_inertia": 0.0})
        links = links.model_copy(update={"payload": links.payload + 1.0})
        more = exact_torque(self.robot.rig.geometry, links, course.theta, course.rate, course.acceleration)
        return more - self._level

    @cached_property
    def _drag(self) -> Floats:
        """(u, 3) J' |P'| P'."""
        course = self.course
        J = kinematics.jacobian(self.robot.rig.geometry, course.theta, course.platform)
        force = np.linalg.norm(course.platform_rate, axis=1)[:, None] * course.platform_rate
        torque: Floats = np.einsum("nij,ni->nj", J, force)
        return torque

    def _held(self, start: float, end: float) -> Floats:
        """(n,) share of a load that is on the platform."""
        time = self.course.time
        up, down = (np.clip((time - instant) / _PICK_UP + 0.5, 0.0, 1.0) for instant in (start, end))
        return up - down

    # Between arm and motor

    def _coupled(self, hidden: "_Hidden", load: Floats) -> tuple[Floats, Floats]:
        """Angle (n, 3) by which the motors are ahead of the course, and torque (n, 3) between them and the arms."""
        twist, half = np.zeros_like(load), np.zeros(3)
        for mask, p in hidden.of("joint_elasticity"):
            # The arms follow the course; the motors are where the springs' torque wants them.
            twist += mask * p["compliance"] * load
        for mask, p in hidden.of("backlash"):
            half += mask * p["b"]
        if not half.any():
            return twist, load
        # The motors follow the course; the arms go where the gap lets them.
        return twist, couplings.play(np.ascontiguousarray(load), self._linear, half, self.course.step)

    @cached_property
    def _linear(self) -> couplings.Linear:
        course = self.course
        once = course.rows[::_COARSE]
        picked, back = np.unique(once, return_inverse=True)
        theta, rate = course.theta[picked], course.rate[picked]
        acceleration = course.acceleration[picked]
        geometry, links = self.robot.rig.geometry, self.robot.links.model_copy(update={"motor_inertia": 0.0})

        def by(vary: Callable[[Floats], tuple[Floats, Floats, Floats]]) -> Floats:
            """Derivative (m, 3, 3) of the torque by what is varied."""
            ways = [[exact_torque(geometry, links, *vary(sign * _SMALL * e)) for e in np.eye(3)] for sign in (1, -1)]
            slope: Floats = np.stack([(up - down) / (2 * _SMALL) for up, down in zip(*ways, strict=True)], axis=2)
            return slope[back]

        return couplings.Linear(
            inertia=by(lambda e: (theta, rate, acceleration + e * 1e4)) / 1e4,
            damping=by(lambda e: (theta, rate + e, acceleration)),
            stiffness=by(lambda e: (theta + e, rate, acceleration)),
            every=_COARSE,
        )

    # The motors

    def _state(self, q: Floats, v: Floats, a: Floats, load: Floats) -> laws.State:
        return laws.State(self.course.time[:, None], q, v, a, load, np.array(self.robot.friction.coulomb))

    def _motor_torque(self, hidden: "_Hidden", q: Floats, v: Floats, a: Floats, load: Floats) -> Floats:
        """(n, 3) inertia and friction of the motors, and what is hidden there."""
        friction, links = self.robot.friction, self.robot.links
        state = self._state(q, v, a, load + links.motor_inertia * a)
        motor_torque = links.motor_inertia * a + friction.viscous * v + state.coulomb * state.direction
        for effect in hidden.effects:
            if name(effect) == "tangled_cables":
                motor_torque = motor_torque + laws.tangled(state, _parameters(effect), effect.joints)
        return motor_torque + hidden.sum(laws.MOTOR, state)

    def _ahead(self, torque: Floats, hidden: "_Hidden") -> Floats:
        """The torque (n, 3) that the voltage stands for: that of a later instant, where there is a delay."""
        delays = sum((mask * p["delay"] for mask, p in hidden.of("actuation_delay")), np.zeros(3))
        if not delays.any():
            return torque
        time = self.course.time
        return np.column_stack(
            [np.interp(time + delay, time, shifted) for delay, shifted in zip(delays, torque.T, strict=True)]
        )

    def _averaged(self, torque: Floats) -> Floats:
        """(m, 3) mean over a sample's time around the instant of the sample."""
        many = self.course.per_sample
        weights = np.r_[0.5, np.ones(many - 1), 0.5] / many
        averaged: Floats = convolve1d(torque, weights, axis=0, mode="nearest")[::many]
        return averaged

    # Drives and sensors

    def _volts(self, torque: Floats, v: Floats, hidden: "_Hidden") -> Floats:
        """(m, 3) reported for the torque at the speed v (m, 3)."""
        rig = self.robot.rig
        gain, exponent = np.array(rig.torque.gain), 2.0 if rig.torque.map == "square" else 1.0
        gain = gain * (1 + sum((mask * p["mismatch"] for mask, p in hidden.of("torque_gain_mismatch")), np.zeros(3)))
        power = exponent + sum((mask * p["excess"] for mask, p in hidden.of("torque_map_exponent")), np.zeros(3))
        volts = np.sign(torque) * np.abs(torque / gain) ** (1 / power)
        if rig.drives[0].voltage.kind == "command":
            for mask, p in hidden.of("amplifier_saturation"):
                used = np.minimum(np.abs(volts) * p["inverse_level"], _FULL)
                volts = np.where(mask, volts / (1 - used ** p["n"]) ** (1 / p["n"]), volts)
            for mask, p in hidden.of("amplifier_deadband"):
                volts = volts + mask * p["width"] * np.sign(volts)
        for mask, p in hidden.of("back_emf"):
            volts = volts + mask * p["k_e"] * v
        reported: Floats = volts
        return reported


class _Hidden:
    """Effects, looked up by name."""

    def __init__(self, effects: Sequence[HiddenEffect]) -> None:
        self.effects = effects

    def of(self, wanted: str) -> Iterator[tuple[Floats, laws.Parameters]]:
        """Mask (3,) of joints, 0 or 1, and parameters of those of that name."""
        for effect in self.effects:
            if name(effect) == wanted:
                yield _mask(effect), _parameters(effect)

    def sum(self, some: dict[str, laws.Law], state: laws.State) -> Floats:
        """(n, 3) torque of those that follow `some` of the laws."""
        torque = np.zeros_like(state.q)
        for effect in self.effects:
            if name(effect) in some:
                torque += _mask(effect) * some[name(effect)](state, _parameters(effect))
        return torque

    def geometry(self, geometry: Geometry) -> Geometry:
        """The lengths that the robot has."""
        for _, p in self.of("geometry_error"):
            longer = {length: getattr(geometry, length) + p["error"] * p[length] for length in ("L1", "L2", "R", "r")}
            geometry = geometry.model_copy(update=longer)
        return geometry

    def gravity(self) -> tuple[float, float, float]:
        """As the base feels it."""
        x, y, z = 0.0, 0.0, -_G
        for _, p in self.of("base_tilt"):
            side, z = _G * np.sin(p["angle"]), -_G * float(np.cos(p["angle"]))
            x, y = float(side * np.cos(p["direction"])), float(side * np.sin(p["direction"]))
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

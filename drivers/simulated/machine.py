"""The simulated machine: plant, joints with their drives, brakes, sensors and hidden effects."""

import math
from collections.abc import Sequence
from functools import reduce

import numpy as np

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, JointState, build, overriding
from drivers.simulated.joint import Joint
from drivers.simulated.model_xml import Arm
from drivers.simulated.plant import Plant
from recordings.errors import BadInput
from recordings.rig import Rig

MAX_STEP = 2e-4
"""Longest step of the plant [s]; stiff joints require it."""
Counts = tuple[int, int, int]


class SimulatedMachine:
    """Three servo axes on the plant. The same generator state and the same calls give bit-identical results."""

    def __init__(self, rig: Rig, config: SimConfig, rng: np.random.Generator) -> None:
        """`rng` generates the noise.

        Raises:
            BadInput: an effect is unknown, has a bad parameter or a size not yet converted to parameters (see
                `sizing.resolve`); or the platform cannot reach its park position.
        """
        self._rig, self._config, self._rng = rig, config, rng
        self._effects = [_build(spec) for spec in config.effects]
        self._events = sorted(
            ((at, _build(effect)) for at, effect in config.effects_that_begin), key=lambda event: event[0]
        )
        self.dt = plant_step(rig.rate)
        """Time step of plant and servo loops [s]."""
        self._state = JointState()
        self._friction = [0.0, 0.0, 0.0]
        self.reset(config.park)

    def reset(self, platform: Sequence[float]) -> None:
        """Put the platform [m] there at rest, power off, brakes on, time zero.

        Raises:
            trajectories.kinematics.Unreachable: the platform cannot reach the position.
        """
        self.enabled = [False, False, False]
        """Power on and position loop closed, per joint; may be set between two calls of `advance`."""
        self.brake = [True, True, True]
        """Holding brake engaged, per joint; may be set likewise."""
        self._steps = self._happened = 0
        self._added_mass = 0.0
        self._assemble()
        # The acceleration before the first step is that under the friction so far.
        self.plant.set_friction(self._friction)
        self.plant.place(platform)
        self._friction = [self._config.servo.brake_torque] * 3
        self.plant.set_friction(self._friction)
        if self.plant.elastic:
            self.plant.settle()
        self._setpoint: Sequence[float] = self.position()

    def _assemble(self) -> None:
        """Make plant and joints of a machine with the effects from the beginning and of the events so far."""
        rig, config = self._rig, self._config
        effects = [*self._effects, *(effect for _, effect in self._events[: self._happened])]
        on_joint = [[effect for effect in effects if i + 1 in effect.joints] for i in range(3)]
        self._joints = [Joint(i, on_joint[i], rig, config, self.dt) for i in range(3)]
        self.plant = _plant(rig, config, effects, on_joint, self.dt)
        read = {variable for effect in effects if effect.reads_state() for variable in effect.variables}
        self._load_matters, self._acceleration_matters = "load" in read, "acceleration" in read
        self._variable_friction = any(joint.variable_friction for joint in self._joints)
        self._masses, self._drags = overriding(effects, "added_mass"), overriding(effects, "drag")

    def set_torque_offsets(self, offsets: Sequence[float]) -> None:
        """Set the torques [N m] that the drives add to the demands of their loops; reset makes them 0."""
        for joint, offset in zip(self._joints, offsets, strict=True):
            joint.torque_offset = offset

    def advance(self, setpoints: Sequence[Sequence[float]]) -> None:
        """Run one step per row of three joint setpoints [rad], at least one row; axes without power ignore them."""
        while self._happened < len(self._events) and self.time >= self._events[self._happened][0]:
            self._happen()
        for joint, enabled, setpoint in zip(self._joints, self.enabled, setpoints[0], strict=True):
            joint.switch(enabled, setpoint)
        self._sense()
        self._set_friction()
        for row in setpoints:
            self._step(row)
        self._setpoint = setpoints[-1]

    def _happen(self) -> None:
        """Go on as a machine that has the effect of the next event, too, in the same state."""
        self._happened += 1
        joints, plant = self._joints, self.plant
        self._assemble()
        for new, old in zip(self._joints, joints, strict=True):
            new.take_over(old)
        self.plant.take_over(plant)
        self.plant.set_added_mass(self._added_mass)
        self.plant.set_friction(self._friction)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.dt

    def position(self) -> list[float]:
        """Joint angles read by the encoders, unquantised [rad]."""
        return [q for q, _ in self._readings()]

    def velocity(self) -> list[float]:
        """Joint speeds read by the encoders [rad/s]."""
        return [v for _, v in self._readings()]

    def torque(self) -> list[float]:
        """Motor torques at the joints [N m]."""
        return [joint.torque for joint in self._joints]

    def reported_torque(self) -> list[float]:
        """Torques of the reported voltages by the rig's torque map, without noise [N m]."""
        return [joint.reported_torque(v) for joint, v in zip(self._joints, self.plant.motor_speeds(), strict=True)]

    def following_error(self) -> list[float]:
        """Last setpoint minus position [rad]."""
        return [setpoint - q for setpoint, q in zip(self._setpoint, self.position(), strict=True)]

    def encoder_counts(self) -> Counts:
        """Encoder counts reported by the drives, with the rig's sign and zero offset."""
        drives = zip(self._rig.drives, self.position(), strict=True)
        first, second, third = (round(drive.to_counts(q)) for drive, q in drives)
        return first, second, third

    def voltage_counts(self) -> Counts:
        """Operating voltages reported by the drives, with new noise and the rig's sign, scale and 16 bits."""
        drives = zip(self._rig.drives, self.voltages(), strict=True)
        counts = (round(drive.sign * volts / drive.voltage.scale) for drive, volts in drives)
        first, second, third = (min(max(count, -0x8000), 0x7FFF) for count in counts)
        return first, second, third

    def voltages(self) -> list[float]:
        """Measured operating voltages, with new noise [V]."""
        speeds, noise = self.plant.motor_speeds(), self._rng.normal(0.0, self._config.voltage_noise, 3).tolist()
        return [joint.voltage(v) + error for joint, v, error in zip(self._joints, speeds, noise, strict=True)]

    def _readings(self) -> list[tuple[float, float]]:
        plant = self.plant
        true = zip(self._joints, plant.motor_angles(), plant.motor_speeds(), strict=True)
        return [joint.read(q, v) for joint, q, v in true]

    def _step(self, setpoint: Sequence[float]) -> None:
        self._sense()
        if self._variable_friction:
            self._set_friction()
        if self._masses:
            self._load_platform()
        if self._drags:
            self._drag_platform()
        state, (first, second, third) = self._state, self._joints
        self.plant.step(
            (first.step(setpoint[0], state), second.step(setpoint[1], state), third.step(setpoint[2], state))
        )
        self._steps += 1

    def _sense(self) -> None:
        state, plant = self._state, self.plant
        state.t, state.q, state.v = self.time, plant.motor_angles(), plant.motor_speeds()
        if self._load_matters:
            state.load = plant.rigid_torque()
        if self._acceleration_matters:
            state.a = plant.motor_accelerations()

    def _load_platform(self) -> None:
        mass = sum(added(self.time) for added in self._masses)
        if mass != self._added_mass:
            self._added_mass = mass
            self.plant.set_added_mass(mass)

    def _drag_platform(self) -> None:
        velocity = self.plant.platform_velocity()
        speed = math.hypot(*velocity)
        resistance = sum(drag(speed) for drag in self._drags)
        self.plant.push([-resistance * component for component in velocity])

    def _set_friction(self) -> None:
        friction = [joint.friction(brake, self._state) for joint, brake in zip(self._joints, self.brake, strict=True)]
        if friction != self._friction:
            self._friction = friction
            self.plant.set_friction(friction)


def plant_step(rate: float) -> float:
    """Longest step [s] up to MAX_STEP such that a cycle at `rate` [Hz] is a whole number of steps."""
    return 1 / (rate * math.ceil(1 / (rate * MAX_STEP) - 1e-9))


def _build(spec: EffectSpec) -> HiddenEffect:
    if spec.size is not None:
        raise BadInput(f"effect {spec.name}: its size must be converted to parameters first (sizing.resolve)")
    return build(spec)


def _plant(
    rig: Rig,
    config: SimConfig,
    effects: Sequence[HiddenEffect],
    on_joint: Sequence[Sequence[HiddenEffect]],
    dt: float,
) -> Plant:
    """The plant with the true properties of the mechanism."""
    geometry = reduce(lambda lengths, effect: effect.geometry(lengths), effects, rig.geometry)
    plant = Plant(
        geometry,
        config.links,
        [reduce(lambda arm, effect: effect.arm(arm), each, Arm.of(config.links)) for each in on_joint],
        [[coupling for effect in each for coupling in effect.couplings()] for each in on_joint],
        viscous=[
            level * math.prod(effect.viscous_share() for effect in each)
            for level, each in zip(config.friction.viscous, on_joint, strict=True)
        ],
        balls=(
            sum(effect.ball_friction()[0] for effect in effects),
            sum(effect.ball_friction()[1] for effect in effects),
        ),
        dt=dt,
    )
    g_x, g_y = ([effect.tilt()[axis] for effect in effects] for axis in (0, 1))
    plant.set_tilt(sum(g_x), sum(g_y))
    return plant

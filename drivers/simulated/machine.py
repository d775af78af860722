"""The machine behind the bus: plant, servo loops, brakes, sensors and hidden effects."""

import math
from collections.abc import Sequence

import numpy as np

from drivers.simulated.config import SimConfig
from drivers.simulated.delay_line import DelayLine
from drivers.simulated.effect import Effect, build, overrides
from drivers.simulated.plant import Plant
from drivers.simulated.servo import Axis
from recordings.errors import BadInput
from recordings.rig import Rig

LONGEST_STEP = 2e-4
"""Of the plant [s]; stiff joints need it this short."""
_JOINTS = range(3)
Counts = tuple[int, int, int]


class Machine:
    """Three servo axes on the plant. The same generator state and the same calls give the same bits."""

    def __init__(self, rig: Rig, config: SimConfig, rng: np.random.Generator) -> None:
        """`rng` makes the noise.

        Raises:
            BadInput: an effect is unknown, has a bad parameter or a size not yet turned into parameters (see
                `sizing.resolve`); or the platform cannot be at its park position.
        """
        self._rig, self._config, self._rng = rig, config, rng
        effects = _effects(config)
        self.dt = step(rig.rate)
        """Of plant and servo loops [s]."""
        self._gain = config.torque_gain or rig.torque.gain
        on_joint = [[effect for effect in effects if joint + 1 in effect.joints] for joint in _JOINTS]
        couplings = [tuple(part for effect in own for part in effect.couplings()) for own in on_joint]
        self._elastic = any(couplings)
        self.plant = Plant(
            rig.geometry,
            config.links,
            (couplings[0], couplings[1], couplings[2]),
            viscous=config.friction.viscous,
            dt=self.dt,
        )
        self.plant.set_tilt(
            *(sum(component) for component in zip(*(e.tilt() for e in effects), (0.0, 0.0), strict=True))
        )
        self._torques = [[e.torque for e in own if overrides(e, "torque")] for own in on_joint]
        self._frictions = [[e.friction for e in own if overrides(e, "friction")] for own in on_joint]
        self._masses = [effect.added_mass for effect in effects if overrides(effect, "added_mass")]
        self._delays = [DelayLine(sum(effect.lag() for effect in own), self.dt) for own in on_joint]
        smoothing = max(round(1 / (rig.rate * self.dt)), 1)
        self._axes = [Axis(config.servo, self.dt, smoothing) for _ in _JOINTS]
        self.reset(config.park)

    def reset(self, platform: Sequence[float]) -> None:
        """At rest with the platform there [m], power off, brakes on, time zero.

        Raises:
            trajectories.kinematics.Unreachable: the platform cannot be there.
        """
        self.enabled = [False, False, False]
        """Power on and position loop closed, per joint; free to be set between two calls of `advance`."""
        self.brake = [True, True, True]
        """Holding brake engaged, per joint; free to be set likewise."""
        self._running = [False, False, False]
        self._steps = 0
        self._added_mass = 0.0
        self.plant.set_added_mass(0.0)
        self.plant.place(platform)
        self._friction = [self._config.servo.brake_torque] * 3
        self.plant.set_friction(self._friction)
        self._torque = [0.0, 0.0, 0.0]
        if self._elastic:
            self.plant.settle()
        self._setpoint: Sequence[float] = self.plant.motor_angles()
        for axis, delay in zip(self._axes, self._delays, strict=True):
            axis.torque = 0.0
            delay.clear()

    def advance(self, setpoints: Sequence[Sequence[float]]) -> None:
        """Run one step per row of three joint positions [rad], at least one row; axes without power ignore them."""
        for joint in _JOINTS:
            if self.enabled[joint] and not self._running[joint]:
                self._axes[joint].restart(setpoints[0][joint])
            self._running[joint] = self.enabled[joint]
        for row in setpoints:
            self._step(row)
        self._setpoint = setpoints[-1]

    @property
    def time(self) -> float:
        """[s]."""
        return self._steps * self.dt

    def position(self) -> list[float]:
        """Joint angles on the encoders' side, unquantised [rad]."""
        return self.plant.motor_angles()

    def velocity(self) -> list[float]:
        """Joint speeds on the encoders' side [rad/s]."""
        return self.plant.motor_speeds()

    def acceleration(self) -> list[float]:
        """Joint accelerations on the encoders' side, in the last step [rad/s^2]."""
        return self.plant.motor_accelerations()

    def torque(self) -> list[float]:
        """What the motors give at the joints [N m]."""
        return list(self._torque)

    def commanded_torque(self) -> list[float]:
        """What the operating voltages stand for [N m]; without an actuation delay the same as `torque`."""
        return [axis.torque for axis in self._axes]

    def following_error(self) -> list[float]:
        """Last setpoint minus position [rad]."""
        return [wanted - q for wanted, q in zip(self._setpoint, self.position(), strict=True)]

    def encoder_counts(self) -> Counts:
        """The encoders as the drives report them, the rig's sign and zero offset included."""
        drives = zip(self._rig.drives, self.position(), strict=True)
        first, second, third = (round((q - drive.zero_offset) * drive.counts_per_radian) for drive, q in drives)
        return first, second, third

    def voltage_counts(self) -> Counts:
        """The operating voltages as the drives report them: noise drawn anew, the rig's sign, scale and 16 bits."""
        first, second, third = (self._voltage_count(i, noise) for i, noise in enumerate(self._noise()))
        return first, second, third

    def _step(self, setpoint: Sequence[float]) -> None:
        plant = self.plant
        angles, speeds = plant.motor_angles(), plant.motor_speeds()
        if self._masses:
            self._load_platform()
        self._set_friction(speeds)
        applied = []
        for i, axis in enumerate(self._axes):
            q, v = angles[i], speeds[i]
            command = axis.follow(setpoint[i], q, v) if self._running[i] else axis.idle()
            torque = self._delays[i].push(command)
            self._torque[i] = torque
            for hidden in self._torques[i]:
                torque -= hidden(q, v)
            applied.append(torque)
        plant.step(applied)
        self._steps += 1

    def _load_platform(self) -> None:
        mass = sum(added(self.time) for added in self._masses)
        if mass != self._added_mass:
            self._added_mass = mass
            self.plant.set_added_mass(mass)

    def _set_friction(self, speeds: Sequence[float]) -> None:
        brake = self._config.servo.brake_torque
        levels = [level + brake * on for level, on in zip(self._config.friction.coulomb, self.brake, strict=True)]
        if any(self._frictions):
            rigid = self.plant.rigid_torque()
            for i in _JOINTS:
                levels[i] += sum(friction(speeds[i], rigid[i]) for friction in self._frictions[i])
        if levels != self._friction:
            self._friction = levels
            self.plant.set_friction(levels)

    def _noise(self) -> list[float]:
        volts: list[float] = self._rng.normal(0.0, self._config.voltage_noise, 3).tolist()
        return volts

    def _voltage_count(self, joint: int, noise: float) -> int:
        share = self._axes[joint].torque / self._gain[joint]
        volts = math.copysign(math.sqrt(abs(share)), share) if self._rig.torque.map == "square" else share
        drive = self._rig.drives[joint]
        count = round(drive.sign * (volts + noise) / drive.voltage.scale)
        return min(max(count, -0x8000), 0x7FFF)


def step(rate: float) -> float:
    """Longest step [s] up to LONGEST_STEP of which the cycles at `rate` [Hz] are whole multiples."""
    return 1 / (rate * math.ceil(1 / (rate * LONGEST_STEP) - 1e-9))


def _effects(config: SimConfig) -> list[Effect]:
    for spec in config.effects:
        if spec.size is not None:
            raise BadInput(f"effect {spec.name}: its size must be turned into parameters first (sizing.resolve)")
    return [build(spec) for spec in config.effects]

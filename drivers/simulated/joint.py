"""One joint of the machine: its drive, its motor, and its torques on the rigid robot."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from drivers.simulated.config import SimConfig
from drivers.simulated.effect import HiddenEffect, JointState, overriding
from drivers.simulated.servo import PositionLoop
from recordings.rig import Rig


@dataclass(frozen=True)
class TorqueMap:
    """Torque of a motor by its voltage: gain |volts|^exponent sgn volts."""

    gain: float
    exponent: float

    def torque(self, volts: float) -> float:
        """Torque [N m] at a voltage [V]."""
        return self.gain * math.copysign(abs(volts) ** self.exponent, volts)

    def volts(self, torque: float) -> float:
        """Voltage [V] for a torque [N m]."""
        ratio = torque / self.gain
        return math.copysign(abs(ratio) ** (1 / self.exponent), ratio)


class Bristle:
    """Dahl's model of presliding friction: z' = v - |v| z / z_s; friction is its level times z / z_s."""

    def __init__(self, displacement: float) -> None:
        """`displacement`: z_s [rad]."""
        self._displacement = displacement
        self._deflection = 0.0

    def step(self, v: float, dt: float) -> float:
        """Friction over its level after `dt` [s] at the speed v [rad/s], opposing v; exact for constant speed."""
        end = math.copysign(1.0, v)
        self._deflection = end + (self._deflection - end) * math.exp(-abs(v) * dt / self._displacement)
        return self._deflection


class Warmth:
    """Warmth of a joint by its own friction: friction times 1 - fall h, with T h' = P / power - h."""

    def __init__(self, fall: float, power: float, time_constant: float, viscous: float, coulomb: float) -> None:
        """`power` P [W] at which friction falls by `fall`; time constant T [s]; friction of the cold joint."""
        self._fall, self._power, self._time_constant = fall, power, time_constant
        self._viscous, self._coulomb = viscous, coulomb
        self._warmth = 0.0

    def changes(self) -> tuple[float, float]:
        """What is missing of viscous [N m s/rad] and of Coulomb friction [N m]."""
        share = -self._fall * self._warmth
        return share * self._viscous, share * self._coulomb

    def step(self, v: float, dt: float) -> None:
        """Warm up for `dt` [s] at the speed v [rad/s]."""
        power = self._viscous * v * v + self._coulomb * abs(v)
        self._warmth += (power / self._power - self._warmth) * dt / self._time_constant


class DelayLine:
    """Delays a sampled signal by any time, with linear interpolation between samples."""

    def __init__(self, delay: float, dt: float) -> None:
        """`delay` and sampling period `dt` [s]."""
        steps = math.floor(delay / dt)
        self._fraction = delay / dt - steps
        self._samples: deque[float] = deque([0.0] * (steps + 2), maxlen=steps + 2)

    def push(self, value: float) -> float:
        """Add the newest sample; returns the delayed one."""
        samples = self._samples
        samples.append(value)
        return samples[1] + self._fraction * (samples[0] - samples[1])

    def fill(self, value: float) -> None:
        """Set all samples to `value`."""
        self._samples.extend([value] * len(self._samples))


class Joint:
    """Chain from a setpoint to the torque on the motor's shaft, and its reported values."""

    def __init__(self, i: int, effects: Sequence[HiddenEffect], rig: Rig, config: SimConfig, dt: float) -> None:
        """`i`: index of the joint, from 0; `effects`: those that act on it; `dt`: plant step [s]."""
        self._i, self._dt = i, dt
        self._axis = PositionLoop(config.servo, dt, smoothing=max(round(1 / (rig.rate * dt)), 1))
        self._rig_map = TorqueMap(rig.torque.gain[i], 2.0 if rig.torque.map == "square" else 1.0)
        self._map = TorqueMap(
            math.prod((effect.gain() for effect in effects), start=(config.torque_gain or rig.torque.gain)[i]),
            self._rig_map.exponent + sum(effect.exponent() for effect in effects),
        )
        self._amplifier_faults = overriding(effects, "amplify")
        self._reports_command = bool(rig.drives) and rig.drives[i].voltage.kind == "command"
        self._back_emf = sum(effect.back_emf() for effect in effects)
        lag, displacement = sum(effect.lag() for effect in effects), sum(effect.bristle() for effect in effects)
        self._delay = DelayLine(lag, dt) if lag else None
        self._bristle = Bristle(displacement) if displacement else None
        viscous, coulomb = config.friction.viscous[i], config.friction.coulomb[i]
        self._warmths = [Warmth(*each, viscous, coulomb) for effect in effects if (each := effect.warming())]
        self._encoders = overriding(effects, "encoder")
        self._torques, self._frictions = overriding(effects, "torque"), overriding(effects, "friction")
        self._coulomb, self._brake_torque = config.friction.coulomb[i], config.servo.brake_torque
        self._presliding = 0.0
        """Level of friction with presliding displacement [N m]."""
        self.variable_friction = bool(self._frictions or self._bristle or self._warmths)
        """Whether the level of dry friction changes from step to step."""
        self.enabled = False
        """Power on and position loop closed."""
        self.torque_offset = 0.0
        """Torque that the drive adds to the demand of its loops [N m]."""
        self.torque = 0.0
        """Torque of the motor [N m]."""

    def take_over(self, other: "Joint") -> None:
        """Go on where another joint stands; its position loop goes on, too."""
        self._axis, self.enabled = other._axis, other.enabled
        self.torque, self.torque_offset = other.torque, other.torque_offset
        if self._delay:
            self._delay.fill(self.torque)

    def switch(self, enabled: bool, setpoint: float) -> None:
        """Open or close the position loop; when closed, it begins by holding `setpoint` [rad]."""
        if enabled and not self.enabled:
            self._axis.restart(setpoint)
        self.enabled = enabled

    def friction(self, brake: bool, state: JointState) -> float:
        """Level [N m] of friction without presliding displacement; `step` adds that with it."""
        level = self._coulomb
        for law in self._frictions:
            level += law(self._i, state)
        level += sum(warmth.changes()[1] for warmth in self._warmths)
        brake_torque = self._brake_torque if brake else 0.0
        if not self._bristle:
            return brake_torque + level
        self._presliding = level
        return brake_torque

    def step(self, setpoint: float, state: JointState) -> float:
        """One step: torque on the shaft [N m]."""
        i = self._i
        if self.enabled:
            q, v = self.read(state.q[i], state.v[i])
            torque = self._axis.follow(setpoint, q, v, self.torque_offset)
        else:
            torque = self._axis.idle()
        if self._amplifier_faults:
            # The loops invert the torque map, but not the faults.
            torque = self._map.torque(self._amplified(self._map.volts(torque)))
        if self._delay:
            torque = self._delay.push(torque)
        self.torque = torque
        for law in self._torques:
            torque -= law(i, state)
        for warmth in self._warmths:
            torque -= warmth.changes()[0] * state.v[i]
            warmth.step(state.v[i], self._dt)
        if self._bristle:
            torque -= self._presliding * self._bristle.step(state.v[i], self._dt)
        return torque

    def _amplified(self, volts: float) -> float:
        """Motor voltage for a commanded voltage [V]."""
        for fault in self._amplifier_faults:
            volts = fault(volts)
        return volts

    def read(self, q: float, v: float) -> tuple[float, float]:
        """Encoder readings for the true angle [rad] and speed [rad/s]."""
        if not self._encoders:
            return q, v
        errors = [encoder(q) for encoder in self._encoders]
        return q + sum(error for error, _ in errors), v * (1 + sum(slope for _, slope in errors))

    def voltage(self, v: float) -> float:
        """Reported voltage without noise [V] at the speed v [rad/s]: the commanded one, or the motor's."""
        volts = self._map.volts(self._axis.torque)
        return (volts if self._reports_command else self._amplified(volts)) + self._back_emf * v

    def reported_torque(self, v: float) -> float:
        """Torque of the reported voltage by the rig's torque map [N m]."""
        return self._rig_map.torque(self.voltage(v))

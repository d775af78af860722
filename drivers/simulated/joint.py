"""One joint of the machine: its drive, its motor, and what it adds to the rigid robot."""

from collections.abc import Sequence

from drivers.simulated.amplifier import Amplifier, torque
from drivers.simulated.bristle import Bristle
from drivers.simulated.config import SimConfig
from drivers.simulated.delay_line import DelayLine
from drivers.simulated.effect import HiddenEffect, JointState, overrides
from drivers.simulated.servo import PositionLoop
from recordings.rig import Rig


class Joint:
    """What lies between a setpoint and the torque on the motor's shaft, and what is reported of it."""

    def __init__(self, i: int, effects: Sequence[HiddenEffect], rig: Rig, config: SimConfig, dt: float) -> None:
        """`i`: number of the joint, from 0; `effects`: those that act on it; `dt`: plant step [s]."""
        self._i, self._dt = i, dt
        self._rig_gain = rig.torque.gain[i]
        self._rig_exponent = 2.0 if rig.torque.map == "square" else 1.0
        self._axis = PositionLoop(config.servo, dt, smoothing=max(round(1 / (rig.rate * dt)), 1))
        self._amplifier = self._make_amplifier(effects, rig, config)
        self._faulty = any(overrides(effect, "amplify") for effect in effects)
        lag, reach = sum(effect.lag() for effect in effects), sum(effect.bristle() for effect in effects)
        self._delay = DelayLine(lag, dt) if lag else None
        self._bristle = Bristle(reach) if reach else None
        self._encoders = [effect.encoder for effect in effects if overrides(effect, "encoder")]
        self._torques = [effect.torque for effect in effects if overrides(effect, "torque")]
        self._frictions = [effect.friction for effect in effects if overrides(effect, "friction")]
        self._coulomb, self._brake_torque = config.friction.coulomb[i], config.servo.brake_torque
        self.enabled = False
        """Power on and position loop closed."""
        self.torque = 0.0
        """What the motor gives [N m]."""

    def _make_amplifier(self, effects: Sequence[HiddenEffect], rig: Rig, config: SimConfig) -> Amplifier:
        gain = (config.torque_gain or rig.torque.gain)[self._i]
        for effect in effects:
            gain *= effect.gain()
        return Amplifier(
            gain=gain,
            exponent=self._rig_exponent + sum(effect.exponent() for effect in effects),
            back_emf=sum(effect.back_emf() for effect in effects),
            faults=[effect.amplify for effect in effects if overrides(effect, "amplify")],
            reports_command=bool(rig.drives) and rig.drives[self._i].voltage.kind == "command",
        )

    def reset(self) -> None:
        """Without power, current and memory."""
        self.enabled = False
        self._axis.torque = self.torque = 0.0
        if self._delay:
            self._delay.clear()
        if self._bristle:
            self._bristle.relax()

    def switch(self, enabled: bool, setpoint: float) -> None:
        """Open or close the position loop; it begins to hold `setpoint` [rad]."""
        if enabled and not self.enabled:
            self._axis.restart(setpoint)
        self.enabled = enabled

    @property
    def variable_friction(self) -> bool:
        """Whether the level of dry friction changes from step to step."""
        return bool(self._frictions or self._bristle)

    def friction(self, brake: bool, now: JointState) -> tuple[float, float]:
        """Levels [N m] of what sticks at once, and of what has to bend first."""
        level = self._coulomb
        for hidden in self._frictions:
            level += hidden(self._i, now)
        held = self._brake_torque if brake else 0.0
        return (held, level) if self._bristle else (held + level, 0.0)

    def step(self, setpoint: float, now: JointState, bent: float) -> float:
        """One step: torque on the shaft [N m]; `bent`: level of the friction that has to bend first [N m]."""
        i = self._i
        if self.enabled:
            q, v = self.read(now.q[i], now.v[i])
            torque = self._axis.follow(setpoint, q, v)
        else:
            torque = self._axis.idle()
        if self._faulty:
            torque = self._amplifier.torque(torque)
        if self._delay:
            torque = self._delay.push(torque)
        self.torque = torque
        for hidden in self._torques:
            torque -= hidden(i, now)
        if self._bristle:
            torque -= bent * self._bristle.step(now.v[i], self._dt)
        return torque

    def read(self, q: float, v: float) -> tuple[float, float]:
        """What the encoder makes of the true angle [rad] and speed [rad/s]."""
        if not self._encoders:
            return q, v
        errors = [encoder(q) for encoder in self._encoders]
        return q + sum(error for error, _ in errors), v * (1 + sum(slope for _, slope in errors))

    def voltage(self, v: float) -> float:
        """What the drive reports, without noise, at the speed v [rad/s]: [V]."""
        return self._amplifier.voltage(self._axis.torque, v)

    def reported_torque(self, v: float) -> float:
        """What this voltage stands for by the rig's torque map [N m]."""
        return torque(self.voltage(v), self._rig_gain, self._rig_exponent)

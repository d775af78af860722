"""One joint of the machine: its drive, its motor, and its torques on the rigid robot."""

from collections.abc import Sequence

from drivers.simulated.amplifier import Amplifier, torque
from drivers.simulated.bristle import Bristle
from drivers.simulated.config import SimConfig
from drivers.simulated.delay_line import DelayLine
from drivers.simulated.effect import HiddenEffect, JointState, overrides
from drivers.simulated.servo import PositionLoop
from recordings.rig import Rig


class Joint:
    """Chain from a setpoint to the torque on the motor's shaft, and its reported values."""

    def __init__(self, i: int, effects: Sequence[HiddenEffect], rig: Rig, config: SimConfig, dt: float) -> None:
        """`i`: index of the joint, from 0; `effects`: those that act on it; `dt`: plant step [s]."""
        self._i, self._dt = i, dt
        self._rig_gain = rig.torque.gain[i]
        self._rig_exponent = 2.0 if rig.torque.map == "square" else 1.0
        self._axis = PositionLoop(config.servo, dt, smoothing=max(round(1 / (rig.rate * dt)), 1))
        self._amplifier = self._make_amplifier(effects, rig, config)
        self._faulty = any(overrides(effect, "amplify") for effect in effects)
        lag, displacement = sum(effect.lag() for effect in effects), sum(effect.bristle() for effect in effects)
        self._delay = DelayLine(lag, dt) if lag else None
        self._bristle = Bristle(displacement) if displacement else None
        self._encoders = [effect.encoder for effect in effects if overrides(effect, "encoder")]
        self._torques = [effect.torque for effect in effects if overrides(effect, "torque")]
        self._frictions = [effect.friction for effect in effects if overrides(effect, "friction")]
        self._coulomb, self._brake_torque = config.friction.coulomb[i], config.servo.brake_torque
        self.enabled = False
        """Power on and position loop closed."""
        self.torque_offset = 0.0
        """Torque that the drive adds to the demand of its loops [N m]."""
        self.torque = 0.0
        """Torque of the motor [N m]."""

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
        """Switch power off and clear current and memory."""
        self.enabled = False
        self._axis.torque = self.torque = self.torque_offset = 0.0
        if self._delay:
            self._delay.clear()
        if self._bristle:
            self._bristle.relax()

    def switch(self, enabled: bool, setpoint: float) -> None:
        """Open or close the position loop; when closed, it begins by holding `setpoint` [rad]."""
        if enabled and not self.enabled:
            self._axis.restart(setpoint)
        self.enabled = enabled

    @property
    def variable_friction(self) -> bool:
        """Whether the level of dry friction changes from step to step."""
        return bool(self._frictions or self._bristle)

    def friction(self, brake: bool, state: JointState) -> tuple[float, float]:
        """Levels [N m] of friction without and with presliding displacement."""
        level = self._coulomb
        for law in self._frictions:
            level += law(self._i, state)
        brake_torque = self._brake_torque if brake else 0.0
        return (brake_torque, level) if self._bristle else (brake_torque + level, 0.0)

    def step(self, setpoint: float, state: JointState, presliding: float) -> float:
        """One step: torque on the shaft [N m]; `presliding`: level of friction with presliding displacement [N m]."""
        i = self._i
        if self.enabled:
            q, v = self.read(state.q[i], state.v[i])
            torque = self._axis.follow(setpoint, q, v, self.torque_offset)
        else:
            torque = self._axis.idle()
        if self._faulty:
            torque = self._amplifier.torque(torque)
        if self._delay:
            torque = self._delay.push(torque)
        self.torque = torque
        for law in self._torques:
            torque -= law(i, state)
        if self._bristle:
            torque -= presliding * self._bristle.step(state.v[i], self._dt)
        return torque

    def read(self, q: float, v: float) -> tuple[float, float]:
        """Encoder readings for the true angle [rad] and speed [rad/s]."""
        if not self._encoders:
            return q, v
        errors = [encoder(q) for encoder in self._encoders]
        return q + sum(error for error, _ in errors), v * (1 + sum(slope for _, slope in errors))

    def voltage(self, v: float) -> float:
        """Reported voltage without noise [V] at the speed v [rad/s]."""
        return self._amplifier.voltage(self._axis.torque, v)

    def reported_torque(self, v: float) -> float:
        """Torque of the reported voltage by the rig's torque map [N m]."""
        return torque(self.voltage(v), self._rig_gain, self._rig_exponent)

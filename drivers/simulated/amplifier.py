"""Voltages between the torque command of a drive's loops and the torque of its motor."""

import math
from collections.abc import Callable, Sequence


class Amplifier:
    """One amplifier with its motor: torque = gain |volts|^exponent sgn volts."""

    def __init__(
        self,
        *,
        gain: float,
        exponent: float,
        back_emf: float = 0.0,
        faults: Sequence[Callable[[float], float]] = (),
        reports_command: bool = False,
    ) -> None:
        """`back_emf`: voltage per joint speed [V s/rad]; `faults`: functions from commanded to motor voltage, applied
        in order; `reports_command`: the drive reports the commanded voltage, not the motor's."""
        self._gain, self._exponent, self._back_emf = gain, exponent, back_emf
        self._faults = faults
        self._reports_command = reports_command

    def torque(self, command: float) -> float:
        """Torque of the motor [N m]; the loops invert its torque map, but not the faults."""
        return torque(self._apply_faults(self._commanded_voltage(command)), self._gain, self._exponent)

    def voltage(self, command: float, speed: float) -> float:
        """Voltage that the drive reports [V] at a joint speed [rad/s]."""
        volts = self._commanded_voltage(command)
        if not self._reports_command:
            volts = self._apply_faults(volts)
        return volts + self._back_emf * speed

    def _commanded_voltage(self, command: float) -> float:
        ratio = command / self._gain
        return math.copysign(abs(ratio) ** (1 / self._exponent), ratio)

    def _apply_faults(self, volts: float) -> float:
        for fault in self._faults:
            volts = fault(volts)
        return volts


def torque(volts: float, gain: float, exponent: float) -> float:
    """Torque [N m] of a motor at a voltage [V]."""
    power: float = abs(volts) ** exponent
    return gain * math.copysign(power, volts)

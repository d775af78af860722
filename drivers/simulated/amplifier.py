"""The voltages between the torque that a drive's loops want and the torque that its motor gives."""

import math
from collections.abc import Callable, Sequence


class Amplifier:
    """One amplifier with its motor, of which torque = gain |volts|^exponent sgn volts."""

    def __init__(
        self,
        *,
        gain: float,
        exponent: float,
        back_emf: float = 0.0,
        faults: Sequence[Callable[[float], float]] = (),
        reports_command: bool = False,
    ) -> None:
        """`back_emf`: voltage per speed of the joint [V s/rad]; `faults`: from commanded volts to those of the motor,
        one after the other; `reports_command`: the drive reports the former, not the latter."""
        self._gain, self._exponent, self._back_emf = gain, exponent, back_emf
        self._faults = faults
        self._reports_command = reports_command

    def torque(self, wanted: float) -> float:
        """What the motor gives [N m]; the loops know its map, but nothing of faults."""
        return torque(self._through(self._command(wanted)), self._gain, self._exponent)

    def voltage(self, wanted: float, speed: float) -> float:
        """What the drive reports [V], at that speed of the joint [rad/s]."""
        volts = self._command(wanted)
        if not self._reports_command:
            volts = self._through(volts)
        return volts + self._back_emf * speed

    def _command(self, wanted: float) -> float:
        share = wanted / self._gain
        volts: float = math.copysign(abs(share) ** (1 / self._exponent), share)
        return volts

    def _through(self, volts: float) -> float:
        for fault in self._faults:
            volts = fault(volts)
        return volts


def torque(volts: float, gain: float, exponent: float) -> float:
    """Torque [N m] of a motor at that voltage [V]."""
    power: float = abs(volts) ** exponent
    return gain * math.copysign(power, volts)

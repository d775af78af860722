"""The units of a simulated drive: what its position and acceleration objects count in, by its own factor objects.

Written without `drivers.canopen`, which the simulated drive tests. The encoder and the gear are those of the machine:
the drive multiplies by its factors whether or not they describe the machine.

CiA 402-2: position = motor turns * feed constant (6092h) / gear ratio (6091h), or the unit in 60A8h; acceleration in
the unit in 60AAh. DSP 402 2.0: increments = position * 6093h, and acceleration in increments/s^2 = object * 6097h, or
the unit of the dimension index in 608Eh with the power of ten in 608Dh. A code that is not listed here means
increments.
"""

import math
from fractions import Fraction

from drivers.simulated.objects import Objects
from recordings.rig import Drive

UNIT_OBJECTS = (*range(0x608D, 0x6098), 0x60A8, 0x60A9, 0x60AA)
"""Objects that the units follow from."""
_REVOLUTIONS, _RPM = 0xB4, 0xC0
_SECONDS = {0x03: 1, 0x47: 60, 0x57: 1}
"""Seconds of each code in a denominator: second, minute (of an acceleration: minute and second), square second."""
_ANGLES = {0x10: 1.0, 0x41: math.pi / 180, 0x42: math.pi / 180 / 60, 0x43: math.pi / 180 / 3600}
"""Radians per unit of each code: radian, degree, minute and second of arc."""
_RAD_PER_SECOND_SQUARED = 0xAE
"""Dimension index of DSP 402 2.0."""
_PLAUSIBLE_RESOLUTION = 16
"""Increments per turn below which 608Fh holds a mere factor, often 1."""


class FactorGroup:
    """Units of one drive with the encoder and gear of the machine in `drive`; `in_increments`: its positions are,
    whatever 6091h and 6092h say."""

    def __init__(self, objects: Objects, drive: Drive, *, in_increments: bool = False) -> None:
        self._objects = objects
        self._in_increments = in_increments
        self._turns_per_radian = drive.gear / (2 * math.pi)
        """Motor turns per radian of the joint."""
        self._increments_per_turn = drive.counts_per_turn
        self._increments_per_radian = abs(drive.counts_per_radian)
        self.refresh()

    def refresh(self) -> None:
        """Compute the units anew, after one of UNIT_OBJECTS was written."""
        self.position = self._position()
        """Position units per encoder increment."""
        self.acceleration = self._acceleration()
        """Acceleration units per rad/s^2 of the joint."""
        self.velocity = self._velocity()
        """Velocity units per rad/s of the joint."""

    def _position(self) -> float:
        code = self._objects.value(0x60A8)
        if code:
            return self._angle_units(code >> 16 & 0xFF) / _power_of_ten(code) / self._increments_per_radian
        # Where all are 1, nobody has set them, and positions are increments.
        has_feed = (0x6092, 1) in self._objects and not self._in_increments
        if has_feed and any(self._ratio(index) != 1 for index in (0x608F, 0x6091, 0x6092)):
            return float(self._ratio(0x6092) / self._ratio(0x6091)) / self._increments_per_turn
        return float(1 / self._ratio(0x6093))

    def _acceleration(self) -> float:
        code = self._objects.value(0x60AA)
        if code:
            return self._coded(code)
        if self._objects.value(0x608E) == _RAD_PER_SECOND_SQUARED:
            return self._angle_units(0x10) * 10.0 ** -self._objects.value(0x608D)
        if (0x6097, 1) in self._objects:
            return self._increments_per_radian / float(self._ratio(0x6097))
        return self._increments_per_radian * self.position

    def _velocity(self) -> float:
        code = self._objects.value(0x60A9)
        return self._coded(code) if code else self._increments_per_radian * self.position

    def _coded(self, code: int) -> float:
        """Units of a speed or an acceleration, per rad/s or rad/s^2 of the joint."""
        numerator, denominator = code >> 16 & 0xFF, code >> 8 & 0xFF
        if numerator == _RPM:
            units = 60 * self._angle_units(_REVOLUTIONS)
        elif denominator in _SECONDS:
            units = _SECONDS[denominator] * self._angle_units(numerator)
        else:
            units = self._increments_per_radian * self.position
        return units / _power_of_ten(code)

    def _angle_units(self, code: int) -> float:
        """Units of angle per radian of the joint; turns are those of the shaft behind the gear of 6091h."""
        shaft_turns = self._turns_per_radian / float(self._ratio(0x6091))
        if code == _REVOLUTIONS:
            return shaft_turns
        if code in _ANGLES:
            return 2 * math.pi * shaft_turns / _ANGLES[code]
        return self._increments_per_radian

    def _ratio(self, index: int) -> Fraction:
        objects = self._objects
        numerator, denominator = objects.value(index, 1, absent=1), objects.value(index, 2, absent=1)
        return Fraction(numerator or 1, denominator or 1)


def _power_of_ten(code: int) -> float:
    exponent = code >> 24 & 0xFF
    return 10.0 ** (exponent - 256 if exponent > 127 else exponent)


def encoder_resolution(objects: Objects) -> int | None:
    """Increments per turn of the motor by 608Fh; None where it says nothing."""
    increments, turns = objects.value(0x608F, 1), objects.value(0x608F, 2, absent=1)
    resolution = increments // (turns or 1)
    return resolution if resolution >= _PLAUSIBLE_RESOLUTION else None

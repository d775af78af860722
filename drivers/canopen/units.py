"""Units of a drive's position, velocity and acceleration, from the objects in which it states them.

CiA 402-2: position units per motor turn = feed constant (6092h) / gear ratio (6091h); 60A8h, 60A9h and 60AAh name
units (top byte: signed power of ten). Their angles belong to the driving shaft: the motor unless 6091h states
a gear; their increments belong to the motor. Older profiles name units by 6089h ... 608Eh (notation and dimension
index), and convert user units to internal ones by the factors 6093h ... 6097h.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from drivers.eds import Address
from recordings.drives import ACCELERATION_UNITS
from recordings.rig import Drive

Objects = Mapping[Address, int]
"""Values of the objects that exist, by index and sub-index."""

OBJECTS: dict[Address, str] = {
    **{(index, 0): layout for index, layout in zip(range(0x6089, 0x608F), ("<b", "<B") * 3, strict=True)},
    **{(index, sub): "<I" for index in range(0x608F, 0x6098) for sub in (1, 2)},
    **{(index, 0): "<I" for index in (0x60A8, 0x60A9, 0x60AA)},
}
"""Objects that state units, with the struct format of their values."""

_POSITION, _VELOCITY, _ACCELERATION = 0x60A8, 0x60A9, 0x60AA

_CODES: dict[int, dict[int, str]] = {
    _POSITION: {
        **{0x10_00_00: "rad", 0x41_00_00: "deg", 0x42_00_00: "arcmin", 0x43_00_00: "arcsec"},
        **{0xB4_00_00: "rev", 0xB5_00_00: "counts"},
    },
    _VELOCITY: {
        **{0x10_03_00: "rad/s", 0x41_03_00: "deg/s", 0xB4_03_00: "rev/s", 0xB5_03_00: "counts/s"},
        **{0xB4_47_00: "rpm", 0xC0_00_00: "rpm"},
    },
    _ACCELERATION: {
        **{0x10_57_00: "rad/s^2", 0x41_57_00: "deg/s^2", 0x42_57_00: "arcmin/s^2", 0x43_57_00: "arcsec/s^2"},
        **{0xB4_57_00: "rev/s^2", 0xB5_57_00: "counts/s^2", 0xB4_47_03: "rpm/s", 0xC0_03_00: "rpm/s"},
    },
}
"""Names of the lower three bytes of 60A8h, 60A9h and 60AAh."""

_DIMENSIONS = {(0x608C, 0xA4): "rpm", (0x608E, 0xAE): "rad/s^2"}
"""The dimension indices of older profiles that makers agree on."""

ELECTRONIC_GEAR = "608Fh and 6091h, read as an electronic gear because they begin with the same number"
_TURNS = {
    **{"rad": 1 / math.tau, "deg": 1 / 360, "arcmin": 1 / 21_600, "arcsec": 1 / 1_296_000},
    **{"rev": 1.0, "rpm": 1 / 60},
}
"""Turns (per second, per second squared) per unit."""

_TOLERANCE = 1e-4
"""Relative difference below which two scales agree; counts_per_turn is a whole number."""


@dataclass(frozen=True)
class Scale:
    """A unit of a drive and its number per rad, rad/s or rad/s^2 of the joint."""

    per_radian: float
    """Positive."""
    name: str
    source: str
    """The object, or the key of the rig file, that states the unit."""


def position_units_per_turn(objects: Objects) -> dict[str, float]:
    """Position units per motor turn, by each group of objects that states them, the likeliest first; empty where none
    does."""
    gear = gear_ratio(objects) or 1.0
    feed, resolution = _ratio(objects, 0x6092), _ratio(objects, 0x608F)
    if (electronic := _ratio(objects, 0x6091)) and _has_electronic_gear(objects):
        return {ELECTRONIC_GEAR: objects[0x608F, 1] / objects[0x608F, 2] / electronic}
    statements = {}
    name, factor = _decoded(objects, _POSITION)
    if name in _TURNS:
        statements["60A8h"] = 1 / (factor * _TURNS[name] * gear)
    elif resolution not in (None, 1.0) and (name == "counts" or feed in (None, 1.0)):
        assert resolution is not None
        statements["608Fh"] = resolution / (_ratio(objects, 0x6093) or 1.0) / factor
    # Factors that are all 1 are those that nobody has set.
    if feed is not None and any(_ratio(objects, index) not in (None, 1.0) for index in (0x608F, 0x6091, 0x6092)):
        statements["6092h and 6091h"] = feed / gear
    return statements


def gear_ratio(objects: Objects) -> float | None:
    """Motor turns per turn of the driving shaft (6091h); None where the drive does not state it."""
    return None if _has_electronic_gear(objects) else _ratio(objects, 0x6091)


def _has_electronic_gear(objects: Objects) -> bool:
    """Whether 6091h holds encoder increments per position unit, as of many servo drives, and no gear."""
    increments = objects.get((0x608F, 1), 0)
    return increments > 1 and objects.get((0x6091, 1)) == increments


def _ratio(objects: Objects, index: int) -> float | None:
    """Sub-index 1 over 2; None where one does not exist or is 0."""
    numerator, divisor = objects.get((index, 1), 0), objects.get((index, 2), 0)
    return numerator / divisor if numerator and divisor else None


def _decoded(objects: Objects, index: int) -> tuple[str | None, float]:
    """Name and power of ten of a unit code; ("", 1) where nothing is stated, (None, ...) where it is unknown."""
    code = objects.get((index, 0), 0)
    exponent = (code >> 24) - (0x100 if code >> 31 else 0)
    return ("", 1.0) if code == 0 else (_CODES[index].get(code & 0xFF_FFFF), 10.0**exponent)


class Units:
    """Units of one drive by its objects, compared with counts_per_turn, gear and units in the rig file."""

    def __init__(self, objects: Objects, drive: Drive) -> None:
        self._objects = objects
        self._drive = drive
        self.problems: list[str] = []
        """Contradictions and unknown codes, with both numbers and what to do."""
        self.readings: Mapping[str, float] = {}
        """Position units per motor turn by each group of objects where they contradict and either may be right."""
        self._motor = drive.gear / math.tau
        """Motor turns per radian of the joint."""
        self._shaft = self._motor / (gear_ratio(objects) or 1.0)
        """Turns of the driving shaft per radian of the joint."""
        resolution = _ratio(objects, 0x608F) or 1.0
        self._encoder: float = drive.counts_per_turn if resolution == 1.0 else resolution
        """Increments per motor turn, where positions may be in another unit."""
        self._check_gear()
        self._check_position()
        self.position = Scale(abs(drive.counts_per_radian), "counts", "counts_per_turn")
        self.velocity = self._stated(_VELOCITY, 0x608C)
        """None: not stated, as of accelerations."""
        self.acceleration = self._acceleration()
        self.question = "" if self.acceleration else self._question()
        """What the rig file must say of the unit of acceleration; "" where it is known."""

    def _check_gear(self) -> None:
        stated, gear = gear_ratio(self._objects), self._drive.gear
        if stated not in (None, 1.0) and not _agree(stated, gear):
            self.problems.append(f"gear: 6091h of the drive says {stated:g}, the rig file {gear:g}; correct one")

    def _check_position(self) -> None:
        counts = self._drive.counts_per_turn
        statements = position_units_per_turn(self._objects)
        others = {source: stated for source, stated in statements.items() if not _agree(stated, counts)}
        # A feed of 1 is what factors are delivered with: it may be meant, or set by nobody.
        if _ratio(self._objects, 0x6092) == 1.0 and 0 < len(others) < len(statements):
            self.readings = statements
        else:
            for source, stated in others.items():
                self.problems.append(
                    f"position units per motor turn: {stated:g} by {source} of the drive, {counts} in the rig file "
                    "(counts_per_turn); correct one"
                )
        if _decoded(self._objects, _POSITION)[0] is None:
            self.problems.append(f"unit of position: {self._code(_POSITION)} is unknown; set the drive to increments")

    def _code(self, index: int) -> str:
        return f"{index:04X}h = {self._objects[index, 0]:08X}h"

    def _stated(self, index: int, dimension: int) -> Scale | None:
        """Scale by 60A9h or 60AAh, otherwise by the dimension index of older profiles and its notation index."""
        name, factor = _decoded(self._objects, index)
        source = f"{index:04X}h"
        if not name:
            name = _DIMENSIONS.get((dimension, self._objects.get((dimension, 0), 0)))
            factor = 10.0 ** self._objects.get((dimension - 1, 0), 0)
            source = f"{dimension:04X}h"
        return None if name is None else self._scale(name, factor, source, self._encoder)

    def _scale(self, name: str, factor: float, source: str, counts_per_turn: float) -> Scale:
        unit = name.split("/")[0]
        per_radian = self._motor * counts_per_turn if unit == "counts" else self._shaft / _TURNS[unit]
        return Scale(per_radian / factor, name if factor == 1 else f"{factor:g} {name}", source)

    def _acceleration(self) -> Scale | None:
        """Scale of accelerations: what drive and rig file state, in agreement."""
        stated = self._stated(_ACCELERATION, 0x608E)
        said = self._drive.units.acceleration
        if said is None:
            return stated
        factor, _, name = said.rpartition(" ")
        chosen = self._scale(name, float(factor or 1), "rig file", self._drive.counts_per_turn)
        if stated is not None and not _agree(stated.per_radian, chosen.per_radian):
            self.problems.append(
                f"1 rad/s^2 of the joint: {stated.per_radian:g} by the drive ({stated.name}, {stated.source}), "
                f"{chosen.per_radian:g} by units.acceleration of the rig file ({chosen.name}); correct one"
            )
        return chosen

    def _question(self) -> str:
        """Text that asks for the unit of acceleration, with what the drive says of it."""
        return (
            f"unit of acceleration: {self._known_of_acceleration()}; find the unit of 6085h in the manual and say it "
            f"in [[drives]], units = {{ acceleration = ... }} ({', '.join(ACCELERATION_UNITS)}, or a factor and one "
            'of these, as in "10 counts/s^2")'
        )

    def _known_of_acceleration(self) -> str:
        if self._objects.get((_ACCELERATION, 0), 0):
            return f"{self._code(_ACCELERATION)} is unknown"
        factor, dimension = _ratio(self._objects, 0x6097), self._objects.get((0x608E, 0), 0)
        if dimension:
            name = _DIMENSIONS.get((0x608C, dimension))
            means = f" ({name}, a unit of speed)" if name else ""
            return f"608Eh = {dimension:X}h{means} is no unit of acceleration that makers agree on"
        if factor not in (None, 1.0):
            # The internal unit of the factor is the maker's: counts/s^2, or counts per square of a sampling time.
            assert factor is not None
            per_radian = self._motor * self._encoder / factor
            return (
                f"6097h of the drive gives {per_radian:g} for 1 rad/s^2 of the joint if the drive's internal unit is "
                "counts/s^2, which it does not say"
            )
        if speed := self.velocity:
            return f"{speed.source} says {speed.name} for speeds, nothing says the unit of accelerations"
        return "the drive does not say it"


def _agree(first: float | None, second: float) -> bool:
    return first is not None and math.isclose(first, second, rel_tol=_TOLERANCE)

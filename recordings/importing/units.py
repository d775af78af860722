"""Units of imported columns: their spelling, dimension and factor to SI."""

import math
import re
from dataclasses import dataclass

from recordings.errors import BadInput, told
from recordings.recording import Floats
from recordings.rig import Drive, JointType

_TURN = 2 * math.pi
_DEGREE = math.pi / 180

_COUNTS = ("counts", "count", "cnt", "inc", "incr", "ticks", "tick", "increments", "pulses", "pulse", "Inkremente")
_DIMENSIONS: dict[str, dict[str, float]] = {
    "angle": {
        **dict.fromkeys(("rad", "radian", "radians"), 1.0),
        "mrad": 1e-3,
        **dict.fromkeys(("deg", "°", "degree", "degrees", "Grad"), _DEGREE),
        "mdeg": 1e-3 * _DEGREE,
        **dict.fromkeys(("turn", "turns", "rev", "revs", "revolutions"), _TURN),
    },
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "cm": 1e-2},
    "angular velocity": {
        **dict.fromkeys(("rad/s", "rad/sec", "rad·s^-1", "1/s"), 1.0),
        "mrad/s": 1e-3,
        **dict.fromkeys(("deg/s", "°/s", "deg/sec", "dps", "Grad/s"), _DEGREE),
        "mdeg/s": 1e-3 * _DEGREE,
        **dict.fromkeys(("turns/s", "turn/s", "rev/s", "rps", "Hz"), _TURN),
        **dict.fromkeys(("rpm", "RPM", "1/min", "rev/min", "U/min", "min^-1"), _TURN / 60),
    },
    "speed": {"m/s": 1.0, "mm/s": 1e-3},
    "torque": {
        **dict.fromkeys(("Nm", "N m", "N·m", "N.m", "N*m", "N-m", "newton metre", "newton meter"), 1.0),
        **dict.fromkeys(("mNm", "mN m", "mN·m", "mN.m"), 1e-3),
        **dict.fromkeys(("kNm", "kN m", "kN·m"), 1e3),
        **dict.fromkeys(("Ncm", "N cm", "N*cm", "N·cm"), 1e-2),
        **dict.fromkeys(("oz-in", "ozf-in", "oz in", "ozin"), 7.061552e-3),
        **dict.fromkeys(("lb-in", "lbf-in", "in-lb", "lb in"), 0.1129848),
    },
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    "current": {"A": 1.0, "mA": 1e-3, "Arms": 1.0, "amp": 1.0},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "temperature": {"degC": 1.0, "°C": 1.0, "C": 1.0, "K": 1.0},
    "time": {
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "Sekunden"), 1.0),
        **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisec", "millisecond", "milliseconds"), 1e-3),
        **dict.fromkeys(("us", "usec", "usecs", "micros", "microsec", "microsecond", "microseconds"), 1e-6),
        **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecond", "nanoseconds"), 1e-9),
        "min": 60.0,
    },
    "counts": dict.fromkeys((*_COUNTS, "qc"), 1.0),
    "count rate": {**dict.fromkeys((f"{name}/s" for name in _COUNTS), 1.0), "qc/s": 1.0},
    "share": {**dict.fromkeys(("%", "percent", "pct"), 1e-2), "permille": 1e-3, "‰": 1e-3},
}
_OFFSETS = {"K": -273.15}
_SCALE = re.compile(r"\s*([*/])\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*$")


@dataclass(frozen=True)
class Unit:
    """A unit with a factor: SI value = number * factor + offset."""

    text: str
    """As written."""
    dimension: str | None
    """None: not stated; the column is in the SI unit of its quantity, times `factor`."""
    factor: float = 1.0
    offset: float = 0.0
    scaled: bool = False
    """Whether a factor was written behind the unit."""


NO_UNIT = Unit("", None)


def parse(text: str) -> Unit | None:
    """Parse "deg", "A*0.12", "counts/8192" or "*-1"; None if there is no such unit.

    Factors are applied to the value in SI units, one after the other. For counts, a turn is one.
    """
    rest, factor, scaled = text.strip(), 1.0, False
    while match := _SCALE.search(rest):
        number = float(match[2])
        if not number or not math.isfinite(number):
            return None
        factor *= number if match[1] == "*" else 1 / number
        rest, scaled = rest[: match.start()].strip(), True
    if not rest:
        return Unit(text, None, factor, scaled=True) if scaled else None
    spelling = _EXPLAINED.sub("", rest.translate(_ALIKE)).strip("[]() ")
    multiple = _MULTIPLE.fullmatch(spelling)
    if multiple and float(multiple[1]):
        factor, spelling = factor * float(multiple[1]), multiple[2]
    for spelled in (spelling, _ANY_CASE.get(spelling.lower(), "")):
        for dimension, factors in _DIMENSIONS.items():
            if spelled in factors:
                return Unit(text, dimension, factor * factors[spelled], _OFFSETS.get(spelled, 0.0) * factor, scaled)
    return None


_ALIKE = str.maketrans({"µ": "u", "μ": "u", "º": "°", "⋅": "·", "•": "·", "∙": "·", "²": "^2"})
_EXPLAINED = re.compile(r"(?<=[^\s(\[])\s*[(\[][^()\[\]]*[)\]]$")
"""Words behind a unit, as in "° (Angle)"."""
_MULTIPLE = re.compile(r"(\d+\.?\d*(?:[eE][-+]?\d+)?)\s*\*?\s*([^\d\s/].*)")
"""A multiple of a unit, such as 0.1%."""
_ANY_CASE = {name.lower(): name for factors in _DIMENSIONS.values() for name in factors if len(name) > 1}
"""Units of more than one letter, by their small letters."""
_BRACKETS = re.compile(r"^(.*?)[\s_/]*[\[(]([^\[\]()]*(?:\([^()]*\))?)[\])]\s*$")


_BORDER = re.compile(r"[\s_/:|<>{}\[\](),-]+")
_ONE_LETTER = re.compile(r"(/|\bin )\s*\w$")
"""What stands before a unit of one letter, which behind a blank is the name of a joint."""


def in_name(name: str) -> Unit | None:
    """Unit that ends or, in brackets, begins a name: "Torque mNm", "Torque in %", "Torque/Nm", "[mNm] Torque"."""
    borders = list(_BORDER.finditer(name))
    ends = [name[border.end() :].strip(_ENDS) for border in borders if border.start()]
    begins = [name[: border.start()].strip(_ENDS) for border in borders if name[0] in "[({<%"]
    for text in (*ends, *begins):
        of_joint = len(text) == 1 and text.isalpha() and not _ONE_LETTER.search(name)
        of_joint |= text == "min" or (text[:1].isdigit() and text[1:2] not in ("/", "."))
        if not of_joint and (unit := parse(text)) and unit.dimension:
            return unit
    return None


_ENDS = "[](){}<>|: "


def split_header(header: str) -> tuple[str, str]:
    """Name of a column, and what stands in brackets behind it, "q1 [deg]": its unit, unless it is an index."""
    match = _BRACKETS.match(header)
    if match and match[1].strip(' "') and not match[2].strip().isdigit() and match[2].strip():
        return match[1].strip(), match[2].strip()
    return header.strip(), ""


def is_none(unit: str) -> bool:
    """Whether the `unit` that a file states says that there is none."""
    return unit.strip("[]() ").lower() in ("", "-", "--", "1", "none", "n/a", "na", "null")


_REVOLUTE = {
    "position": ("angle", "counts"),
    "command": ("angle", "counts"),
    "velocity": ("angular velocity", "count rate"),
    "effort": ("torque", "current", "share"),
}
_PRISMATIC = {
    "position": ("length", "counts"),
    "command": ("length", "counts"),
    "velocity": ("speed", "count rate"),
    "effort": ("force", "current", "share"),
}
_ANY_JOINT = {
    "time": ("time",),
    "cycle": (),
    "voltage": ("voltage",),
    "current": ("current",),
    "temperature": ("temperature",),
}
_EXAMPLES = {
    "angle": "rad, deg, turns",
    "counts": "counts/8192 (counts per turn)",
    "length": "m, mm",
    "angular velocity": "rad/s, deg/s, rpm",
    "speed": "m/s, mm/s",
    "count rate": "counts/s/8192",
    "torque": "Nm, mNm",
    "force": "N",
    "current": "A, mA",
    "share": "%*20 (Nm at 100 %)",
    "voltage": "V, mV",
    "temperature": "degC, K",
    "time": "s, ms, us, ns",
}


def quantity_of(unit: Unit) -> str | None:
    """Quantity of a joint, or time, that a column in `unit` most likely holds; None where it says nothing."""
    for table in (_ANY_JOINT, _REVOLUTE, _PRISMATIC):
        for quantity, dimensions in table.items():
            if dimensions and unit.dimension == dimensions[0]:
                return quantity
    return None


def check_dimension(unit: Unit, quantity: str, *, prismatic: bool, where: str) -> None:
    """Check that a column of `quantity` can be in `unit`.

    Raises:
        BadInput: the dimension is another one, or a conversion needs a factor that is missing.
    """
    accepted = (_ANY_JOINT | (_PRISMATIC if prismatic else _REVOLUTE))[quantity]
    if unit.dimension is None:
        return
    if unit.dimension not in accepted:
        kind = f" of a {'prismatic' if prismatic else 'revolute'} joint" if quantity not in _ANY_JOINT else ""
        examples = ", ".join(_EXAMPLES[dimension] for dimension in accepted) or "a number without unit"
        raise BadInput(
            f"{where}: {examples} expected for the {quantity}{kind}, '{unit.text}' found; correct the unit"
        )


@dataclass(frozen=True)
class RigHints:
    """What is known of the joints before the rig is: their types, and their drives if there is a rig file."""

    types: tuple[JointType, ...] = ("revolute",)
    drives: tuple[Drive, ...] = ()

    def prismatic(self, joint: int) -> bool:
        """Whether `joint` is prismatic; a single type is that of all joints."""
        return (self.types[joint] if joint < len(self.types) else self.types[0]) == "prismatic"

    def drive(self, joint: int) -> Drive | None:
        """Drive of `joint`; None where it is not known."""
        return self.drives[joint] if joint < len(self.drives) else None


def to_si(values: Floats, unit: Unit, quantity: str, joint: int, rig: RigHints, where: str) -> Floats:
    """Convert the `values` (n,) of a joint, counted from 0, to SI units.

    Raises:
        BadInput: as `check_dimension`; or neither the unit nor the rig says the counts per turn, or the rated torque.
    """
    prismatic = rig.prismatic(joint)
    check_dimension(unit, quantity, prismatic=prismatic, where=where)
    if unit.dimension in ("counts", "count rate", "share", "current") and quantity != "current" and not unit.scaled:
        return _by_drive(values, unit, quantity, rig.drive(joint), where)
    turn = _TURN if unit.dimension in ("counts", "count rate") and not prismatic else 1.0
    return values * (unit.factor * turn) + unit.offset


def _by_drive(values: Floats, unit: Unit, quantity: str, drive: Drive | None, where: str) -> Floats:
    """Convert counts and shares of the rated torque with the drive of a rig file."""
    if drive is None or unit.dimension == "current":
        rig = told("--rig", "a rig")
        remedy = {
            "counts": f"write counts/8192 for 8192 counts per turn of the joint, or give {rig} with [[drives]]",
            "count rate": f"write counts/s/8192 for 8192 counts per turn of the joint, or give {rig} with [[drives]]",
            "share": f"write %*20 for 20 Nm at 100 %, or give {rig} with [[drives]]",
            "current": "write A*0.12 for 0.12 Nm/A, or map the column to current_1 ... and give "
            + told("--kt", "a rig with torque.per_ampere"),
        }[unit.dimension or ""]
        raise BadInput(f"{where}: '{unit.text}' needs a factor to become {quantity}; {remedy}")
    if unit.dimension == "counts":
        return drive.to_position(values * unit.factor)
    if unit.dimension == "count rate":
        return values * (unit.factor / drive.counts_per_radian)
    return values * (unit.factor * drive.rated_torque)

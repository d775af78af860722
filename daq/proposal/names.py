"""What the names of a dictionary say: objects of the motor's voltage and of states, the unit of a ramp."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

from daq.proposal.facts import DriveFacts
from drivers.eds import Address

_MOTOR = re.compile(r"\b(motor|output|terminal|phase|winding)\b", re.IGNORECASE)
_OTHER = re.compile(
    r"\b(threshold|limit|level|protect|under|over|max|min\b|minimum|nominal|rated|analog|digital|supply|bus|link"
    r"|brake|sensor|encoder|phase\W*[a-cu-w1-3]\b|[a-cu-w]\W*phase)",
    re.IGNORECASE,
)
"""Voltages of something else, and of one phase of several: it alternates with the angle of the rotor."""
_UNIT = re.compile(r"\b(?P<factor>0?\.\d+|1) ?(?P<unit>m?V)\b|\[(?P<plain>m?V)\]|\b(?P<bare>mV)\b")
_TOUCH_PROBE = {0x60B9: "touch probe status", 0x60BA: "touch probe 1, rising edge"}
_ACCELERATION_UNITS = {
    **dict.fromkeys(("count", "cnt", "inc", "pulse", "increment"), "counts/s^2"),
    **{"rpm": "rpm/s", "rev": "rev/s^2", "r": "rev/s^2", "rad": "rad/s^2", "deg": "deg/s^2"},
}
_ACCELERATION = re.compile(
    r"(?P<factor>\d+(\.\d+)?)? ?\b(?P<unit>rpm(?= ?/ ?s\b)"
    r"|(count|cnt|inc|pulse|increment|rev|r|rad|deg)(?=s? ?/ ?s(\^2|2|²|/s)))",
    re.IGNORECASE,
)
"""As in "10 counts/s^2"."""
_SAFE_TORQUE_OFF = re.compile(r"\bSTO\b|safe.torque", re.IGNORECASE)


@dataclass(frozen=True)
class VoltageObject:
    """An object whose name says that it holds the motor's voltage."""

    address: Address
    name: str
    scale: float | None
    """Voltage per count [V]; None: the name does not say it."""
    mappable: bool


def motor_voltage(facts: DriveFacts) -> VoltageObject | None:
    """The manufacturer's object of the motor voltage, by its name; a drive that is read does not tell names."""
    for address, item in sorted(facts.descriptions.items()):
        name = item.name
        is_voltage = "voltage" in name.lower() and _MOTOR.search(name) and not _OTHER.search(name)
        if 0x2000 <= address[0] < 0x6000 and item.size in (1, 2, 4) and item.is_readable and is_voltage:
            return VoltageObject(address, name, _scale(name), item.mappable)
    return None


def _scale(name: str) -> float | None:
    match = _UNIT.search(name)
    if match is None:
        return None
    unit = match["unit"] or match["plain"] or match["bare"]
    return float(match["factor"] or 1) * (1e-3 if unit == "mV" else 1.0)


def named_acceleration(facts: DriveFacts) -> tuple[str, str] | None:
    """Unit of acceleration in the name of a ramp, and that name."""
    for index in (0x6085, 0x6084, 0x6083):
        item = facts.descriptions.get((index, 0))
        if item is not None and (match := _ACCELERATION.search(item.name)):
            unit = _ACCELERATION_UNITS[match["unit"].lower()]
            return f"{match['factor'] or ''} {unit}".strip(), item.name
    return None


def states(facts: DriveFacts) -> Iterator[str]:
    """Touch probe and Safe Torque Off, as far as the drive has objects for them, as TOML."""
    names = {(index, 0): name for index, name in _TOUCH_PROBE.items() if (index, 0) in facts}
    for address, item in sorted(facts.descriptions.items()):
        if _SAFE_TORQUE_OFF.search(item.name) and item.is_readable and item.size in (1, 2, 4):
            names[address] = item.name
    for (index, sub), name in names.items():
        yield f"{{ index = 0x{index:04X}, {f'sub = {sub}, ' if sub else ''}name = {json.dumps(name)} }}"

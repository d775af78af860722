"""Choices of a proposal: mode of operation, what the torque is found from, rate."""

from collections.abc import Sequence
from typing import Literal

from daq.proposal.facts import DriveFacts
from daq.proposal.names import motor_voltage
from daq.proposal.text import ASSUMED, STATED
from drivers.canopen.requirements import interpolation_period
from drivers.eds import Address
from recordings.errors import BadInput

Mode = Literal["cyclic", "interpolated"]
TorqueSource = Literal["voltage", "torque_actual", "current_actual", "none"]

MODES: tuple[tuple[Mode, int, Address], ...] = (("cyclic", 8, (0x607A, 0)), ("interpolated", 7, (0x60C1, 1)))
"""Modes that follow targets, the preferred one first, with their numbers and targets."""
_TORQUE, _CURRENT = (0x6077, 0), (0x6078, 0)
USUAL_RATE = 500.0
"""[Hz]."""
_RATES = (USUAL_RATE, 1000.0, 250.0, 200.0, 125.0, 100.0, 50.0)


def mode_of(facts: DriveFacts) -> tuple[Mode, str]:
    """Mode of operation, and why, as a comment.

    Raises:
        BadInput: the drive has neither mode, with the reason.
    """
    modes = facts.value(0x6502)
    listed = {mode: not modes or bool(modes >> number - 1 & 1) for mode, number, _ in MODES}
    said = "6502h does not say which modes the drive has" if not modes else f"6502h = {modes:X}h"
    for mode, number, target in MODES:
        if listed[mode] and not facts.lack(target):
            return (
                mode,
                f"{STATED if modes else ASSUMED}{said}: mode {number}, its target {name_of(target)} can be mapped",
            )
    if not any(listed.values()):
        raise BadInput(
            f"{facts.origin}: {said}: neither mode 8 (cyclic synchronous position) nor mode 7 (interpolated "
            "position) is there; this drive cannot follow a motion that is streamed to it"
        )
    lacks = "; ".join(facts.lack(target) for mode, _, target in MODES if listed[mode])
    raise BadInput(f"{facts.origin}: {lacks}; this drive cannot follow targets in time")


def torque_sources(facts: DriveFacts) -> list[TorqueSource]:
    """What the torque of a drive can be found from, the best first: a torque, a current, a voltage of the motor."""
    found: dict[TorqueSource, bool] = {
        "torque_actual": not facts.lack(_TORQUE),
        "current_actual": not facts.lack(_CURRENT),
        "voltage": motor_voltage(facts) is not None,
    }
    return [source for source, is_there in found.items() if is_there]


def common_torque_source(drives: Sequence[DriveFacts]) -> TorqueSource:
    """The best torque source that all drives have.

    Raises:
        BadInput: there is none, with what may be done.
    """
    sources = [(facts.origin, torque_sources(facts)) for facts in drives]
    for source in sources[0][1]:
        if all(source in others for _, others in sources):
            return source
    for facts, (origin, found) in zip(drives, sources, strict=True):
        if not found:
            raise BadInput(
                f"{origin}: nothing to find the torque from: {facts.lack(_TORQUE)}; {facts.lack(_CURRENT)}; "
                "and no object is named as the motor's voltage. Look for one in the "
                "manual: with --eds, correct the file where it hides one (PDOMapping, ParameterName), or write "
                "voltage in [[drives]] of a rig file by hand (docs/how-to/drive-dictionaries.md). To "
                "commission without a torque: daq rig propose --torque none"
            )
    listed = "; ".join(f"{origin}: {', '.join(found)}" for origin, found in sources)
    raise BadInput(f"one torque source for all drives expected, none in common found ({listed}); choose other drives")


def rates_of(drives: Sequence[DriveFacts]) -> list[float]:
    """Cycle rates [Hz] that all drives accept in 60C2h, the best first.

    Raises:
        BadInput: there is none.
    """
    accepted = [rate for rate in _RATES if all(_accepts(facts, rate) for facts in drives)]
    if not accepted:
        raise BadInput("the drives accept no common period in 60C2h; check the limits of that object in their EDS")
    return accepted


def _accepts(facts: DriveFacts, rate: float) -> bool:
    places = [((0x60C2, sub), value) for sub, value in enumerate(interpolation_period(rate), start=1)]
    return not any(address in facts and facts.dictionary().refuses(address, value) for address, value in places)


def name_of(address: Address) -> str:
    """An object as manuals print it, e.g. 60C1h:01."""
    return f"{address[0]:04X}h" + (f":{address[1]:02X}" if address[1] else "")

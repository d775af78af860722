"""What keeps a drive from being driven by this rig file, from its dictionary alone: no bus, nothing is written."""

import math
from collections.abc import Iterator

from drivers.canopen.dictionary import DriveDictionary
from drivers.canopen.pdo import TARGET
from drivers.canopen.roles import ROLES, without
from drivers.canopen.setup import MODES
from recordings.drives import STATUSWORD

RATING_TOLERANCE = 0.01
"""Relative difference below which ratings of the drive and of the rig file agree."""
_GUARDS = {0x1016: ("guarding", "rpdo")}
"""Other ways to notice a lost master than 1016h."""
_PLAUSIBLE = {"607Dh": (0.1, 1000.0), "6065h": (0.001, 100.0), "6064h": (0.0, 1000.0)}
"""Turns of a motor that a range of travel, a following error and a position may be."""
_UNSET = (-(2**31), 2**31 - 1, 2**32 - 1)
"""Limits that limit nothing."""


def missing_for_motion(dictionary: DriveDictionary) -> Iterator[str]:
    """Objects without which the drive cannot follow targets of the rig's mode."""
    target = TARGET[dictionary.drive.mode].address
    for index, sub in ((STATUSWORD, 0), (0x6060, 0), (0x6064, 0), target):
        if (index, sub) not in dictionary:
            yield f"{index:04X}:{sub:02X} {ROLES[index].meaning}: no such object"
    if dictionary.drive.torque_offset and (0x60B2, 0) not in dictionary:
        yield "60B2:00 torque offset: no such object, so no torque can be fed forward; drop --feedforward"
    for address in ((0x6064, 0), target):
        data = dictionary.data.get(address)
        if data and len(data) != 4:
            yield f"{address[0]:04X}:{address[1]:02X}: 4 bytes expected, {len(data)} found"


def missing_for_safety(dictionary: DriveDictionary) -> list[int]:
    """Objects of safety that the drive lacks, and for which it has no other means."""
    indices = {index for index, _ in dictionary.data}
    return [
        index
        for index, role in ROLES.items()
        if role.role == "safety" and index not in indices and dictionary.watchdog not in _GUARDS.get(index, ())
    ]


def not_accepted(dictionary: DriveDictionary) -> list[int]:
    """Objects of safety that the drive lacks and the rig file does not accept as missing."""
    accepted = {int(index, 16) for index in dictionary.drive.accept_missing}
    return [index for index in missing_for_safety(dictionary) if index not in accepted]


def unit_problems(dictionary: DriveDictionary) -> list[str]:
    """Contradictions and gaps in the units of the drive and of the rig file, also in the rated torque (6076h), which
    scales torque offsets."""
    drive, units, rated = dictionary.drive, dictionary.units, dictionary.rated_torque
    problems = list(units.problems)
    if units.question and dictionary.has_ramp:
        problems.append(units.question)
    if drive.torque_offset and not math.isclose(rated, drive.rated_torque, rel_tol=RATING_TOLERANCE):
        problems.append(
            f"rated torque: 6076h of the drive gives {rated:g} N m at the joint ({rated / drive.gear:g} N m of the "
            f"motor times gear {drive.gear:g}), rated_torque of the rig file is {drive.rated_torque:g} N m; correct "
            "one"
        )
    return problems


def position_doubt(dictionary: DriveDictionary) -> str:
    """Ask which of two units a drive means that states both, and say what its values show; "" where it states one, or
    the motion of the joint has decided."""
    readings = dictionary.units.readings
    if not readings or dictionary.drive.counts_source == "measured":
        return ""
    said = ", ".join(f"{source} say {per_turn:g}" for source, per_turn in readings.items())
    against = [
        f"by {source}, {name} = {length} would be {length / per_turn:g} turns of the motor"
        for source, per_turn in readings.items()
        for name, length in _lengths(dictionary)
        if not _PLAUSIBLE[name][0] <= length / per_turn <= _PLAUSIBLE[name][1]
    ]
    return (
        f"{said}: either may be right ({'; '.join(against) or 'its other values do not decide'}). Turn the joint by "
        "hand, without power, and compare with the joint angle of daq check; daq jog or daq axis-check (--write) "
        'decides, by counts_source = "measured" in [[drives]]'
    )


def _lengths(dictionary: DriveDictionary) -> Iterator[tuple[str, int]]:
    """Lengths that the drive holds, in its unit of position."""
    low, high = (dictionary.value((0x607D, sub)) or 0 for sub in (1, 2))
    lengths = {"607Dh": 0 if {low, high} & {*_UNSET} else high - low, "6065h": dictionary.value((0x6065, 0)) or 0}
    lengths["6064h"] = abs(dictionary.value((0x6064, 0)) or 0)
    yield from ((name, length) for name, length in lengths.items() if length > 0 and length not in _UNSET)


def mode_problem(dictionary: DriveDictionary) -> str | None:
    """Why the drive may not have the rig's mode (6502h); None: it has it, or the rig file assumes it."""
    drive, modes = dictionary.drive, dictionary.value((0x6502, 0))
    name = f"mode {MODES[drive.mode]} ({drive.mode})"
    if modes:
        others = [other for other, number in MODES.items() if modes >> number - 1 & 1]
        if drive.mode in others:
            return None
        advice = f'mode = "{others[0]}" is there' if others else "neither mode 7 nor 8 is there"
        return f"6502h = 0x{modes:X}: {name} not supported; {advice}"
    if drive.assume_mode:
        return None
    absent = "is 0" if modes == 0 else "is absent"
    return f"6502h {absent}, so the drive does not say whether it has {name}; assume_mode = true tries it"


def problems(dictionary: DriveDictionary) -> list[str]:
    """Everything that keeps a run from starting."""
    mode = mode_problem(dictionary)
    safety = [
        f"{index:04X}h ({ROLES[index].meaning}) is missing: {without(index)}" for index in not_accepted(dictionary)
    ]
    return [*missing_for_motion(dictionary), *unit_problems(dictionary), *([mode] if mode else []), *safety]

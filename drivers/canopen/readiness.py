"""Whether a drive can be driven by this rig file, from its dictionary alone: no bus, nothing is written.

Each finding is one sentence, the same in `daq rig propose`, `daq check` and before a run.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from drivers.canopen import pdo, setup
from drivers.canopen.dictionary import DriveDictionary
from drivers.canopen.requirement import Requirement
from drivers.canopen.requirements import MODES, PDO, ROWS, TABLE
from drivers.canopen.sdo import SdoWrite, format_address
from drivers.eds import Address
from drivers.protocol import Verdict
from recordings.errors import BadInput
from recordings.rig import Rig

DRIVE_PROFILE = 402
"""Of CiA, in the lower half of 1000h."""
RATING_TOLERANCE = 0.01
"""Relative difference below which ratings of the drive and of the rig file agree."""
_PLAUSIBLE = {"607Dh": (0.1, 1000.0), "6065h": (0.001, 100.0), "6064h": (0.0, 1000.0)}
"""Turns of a motor that a range of travel, a following error and a position may be."""
_UNSET = (-(2**31), 2**31 - 1, 2**32 - 1)
"""Limits that limit nothing."""


@dataclass(frozen=True)
class DriveFinding:
    """One thing that a drive lacks, or that contradicts the rig file."""

    what: str
    expected: str
    found: str
    verdict: Verdict = "problem"
    row: Requirement | None = None
    """Of the object that it is about, where it has one."""
    of_value: bool = False
    """Whether the object takes other values."""

    @property
    def is_final(self) -> bool:
        """Whether no rig file can do anything about it."""
        row = self.row
        return self.verdict == "problem" and row is not None and row.role == "motion" and not row.key

    @property
    def contradicts(self) -> bool:
        """Whether the drive's file names an object of the motion as something else."""
        return self.verdict == "noted" and self.row is not None and self.row.role == "motion"

    @property
    def sentence(self) -> str:
        """The finding where no table is."""
        return f"{self.what}: {self.found}"


def findings(rig: Rig, dictionary: DriveDictionary) -> list[DriveFinding]:
    """All that a run would meet, as far as the drive and its file tell."""
    judged: dict[int, DriveFinding] = {}
    for row in _rows(dictionary):
        if finding := _judged(rig, dictionary, row):
            # Sub-indices of one object are accepted together.
            judged.setdefault(row.address[0], finding)
    found = [*_profile(dictionary), *judged.values(), *_mode(dictionary), *_units(dictionary)]
    try:
        setup.object_writes(rig, dictionary)
        writes = pdo.pdo_writes(dictionary)
    except BadInput as error:
        return [*found, DriveFinding("set-up", "objects that suffice", str(error))]
    return [*found, *_pdo_problems(dictionary, writes)]


def problems(rig: Rig, dictionary: DriveDictionary) -> list[str]:
    """Everything that keeps a run from starting."""
    return [finding.sentence for finding in findings(rig, dictionary) if finding.verdict == "problem"]


def _rows(dictionary: DriveDictionary) -> Iterator[Requirement]:
    """The rows that this drive must fulfil, with the objects that the rig file names."""
    drive = dictionary.drive
    yield from (row for row in TABLE if row.needed(dictionary))
    if drive.torque_source == "voltage":
        use = "m" if drive.voltage.transfer == "pdo" else "r"
        yield Requirement(
            (drive.voltage.index, drive.voltage.sub), "<h", "motion", "voltage", use, quantity="voltage"
        )
    for watched in drive.watched:
        yield Requirement((watched.index, watched.sub), "<I", "motion", f"watched {watched.name}".rstrip(), "r")
    if drive.homed is not None and (drive.homed.index, drive.homed.sub) not in ROWS:
        yield Requirement((drive.homed.index, drive.homed.sub), "<I", "motion", "zero reference (homed)", "r")


def _judged(rig: Rig, dictionary: DriveDictionary, row: Requirement) -> DriveFinding | None:
    """The finding of one object that is missing, or not what the run needs."""
    lack, refusal = dictionary.lack(row), ""
    if not lack:
        with suppress(BadInput):  # which `findings` says
            value = row.wanted(rig, dictionary)
            refusal = "" if value is None else dictionary.refuses(row.address, value)
    if doubt := "" if lack or refusal else dictionary.misnamed(row) or dictionary.doubt(row):
        return DriveFinding(_what(row.address, row), "as the standard says", doubt, "noted", row)
    return _found(dictionary, row, lack or refusal) if lack or refusal else None


def _found(dictionary: DriveDictionary, row: Requirement, text: str) -> DriveFinding:
    """The finding of what an object lacks, with what may be done."""
    what, item = _what(row.address, row), dictionary.descriptions.get(row.address)
    if row.role == "convenience":
        return DriveFinding(what, "optional", f"{text}, left out", "noted", row)
    if row.role == "safety" and f"{row.address[0]:04X}" in dictionary.drive.accept_missing:
        return DriveFinding(what, "needed for safety", f"{text}; {row.loss}; {row.instead}", "accepted", row)
    fitting = [f"{value}" for value in row.choices if item is not None and not dictionary.refuses(row.address, value)]
    text += f"; {row.key} = {' or '.join(fitting)} in [[drives]]" if fitting else ""
    text += f"; {row.waiver if row.role == 'safety' else row.instead}" if row.instead else ""
    takes_others = item is not None and item.is_writable and not dictionary.lack(row)
    return DriveFinding(what, f"needed for {row.role}", text, row=row, of_value=takes_others)


def _what(address: Address, row: Requirement) -> str:
    return f"{format_address(*address)} {row.meaning}"


def _pdo_problems(dictionary: DriveDictionary, writes: list[SdoWrite]) -> Iterator[DriveFinding]:
    """What the drive's file excludes of the set-up of our PDOs."""
    for write in writes:
        if not pdo.is_foreign(write) and (refusal := dictionary.refusal(write)):
            yield DriveFinding(_what((write.index, write.sub), PDO), f"0x{write.value:X}", refusal, row=PDO)


def _profile(dictionary: DriveDictionary) -> Iterator[DriveFinding]:
    profile = (dictionary.value((0x1000, 0)) or 0) & 0xFFFF
    if profile not in (0, DRIVE_PROFILE):
        row, text = ROWS[0x1000, 0], f"profile {profile}, which is of no drive"
        yield DriveFinding("1000:00 device type", f"profile {DRIVE_PROFILE}", text, row=row)


def _mode(dictionary: DriveDictionary) -> Iterator[DriveFinding]:
    """Why the drive may not have the rig's mode (6502h)."""
    drive, modes = dictionary.drive, dictionary.value((0x6502, 0))
    name = f"mode {MODES[drive.mode]} ({drive.mode})"
    others = [other for other, number in MODES.items() if (modes or 0) >> number - 1 & 1]
    if drive.mode in others or (not modes and drive.assume_mode):
        return
    if modes:
        advice = f'mode = "{others[0]}" is there' if others else "neither mode 7 nor 8 is there"
        text = f"0x{modes:X}, without {name}; {advice}"
    else:
        text = (
            f"{'absent' if modes is None else 'none named'}, so {name} may not be there; assume_mode = true tries it"
        )
    yield DriveFinding("6502:00 supported modes", name, text)


def _units(dictionary: DriveDictionary) -> Iterator[DriveFinding]:
    """Contradictions and gaps in the units of the drive and of the rig file, also in the rated torque (6076h), which
    scales torque offsets."""
    drive, units, rated = dictionary.drive, dictionary.units, dictionary.rated_torque
    texts = [*units.problems, *([units.question] if units.question and dictionary.has_ramp else [])]
    if drive.torque_offset and not math.isclose(rated, drive.rated_torque, rel_tol=RATING_TOLERANCE):
        texts.append(
            f"rated torque: 6076h of the drive gives {rated:g} N m at the joint ({rated / drive.gear:g} N m of the "
            f"motor times gear {drive.gear:g}), rated_torque of the rig file is {drive.rated_torque:g} N m; correct "
            "one"
        )
    for what, _, text in (each.partition(": ") for each in texts):
        yield DriveFinding(what, "drive and rig file agree", text)


def position_doubt(dictionary: DriveDictionary) -> str:
    """Ask which of two units a drive means that states both, and say what its values show; "" where it states one, or
    the motion of the joint has decided."""
    readings = dictionary.units.readings
    if not readings or dictionary.drive.counts_source == "measured":
        return ""
    said = ", ".join(f"{per_turn:g} by {source}" for source, per_turn in readings.items())
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

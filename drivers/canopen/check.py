"""Compare CANopen drives with the rig file before anything is written, for `daq check`."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress

from drivers import cia402
from drivers.canopen import dcf, pdo, readiness, setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.dictionary import DriveDictionary, read_dictionary
from drivers.canopen.requirement import Requirement
from drivers.canopen.requirements import MODES, PDO, WATCHDOG, row_of
from drivers.canopen.sdo import READ_DEVICE_TYPE, SdoWrite, format_address
from drivers.canopen.units import Scale
from drivers.protocol import CheckResult, Power, Verdict
from recordings.drives import PROTECTIONS, STATUSWORD
from recordings.errors import BadInput
from recordings.rig import Rig

_SCAN_TIMEOUT = 0.3
"""Time that the scan waits for the last answer [s]."""
_REQUEST_INTERVAL = 0.0005
"""Time between two requests of the scan, so that no interface's queue overflows [s]."""
_NODE_IDS = range(1, 128)
_PROTECTING = ((0x1016, 0x6007), (0x6065, 0x6066), (0x607D,), (0x605A, 0x605E, 0x6085))
"""Objects of each of PROTECTIONS."""
_VOLTAGE_ENABLED = 0x10
"""Statusword bit 4."""
_SI = {"position": "rad", "velocity": "rad/s", "acceleration": "rad/s^2"}
_RADIANS_PER_SECOND_PER_RPM = math.tau / 60

Row = tuple[str, str, str, Verdict]
"""What was compared, expected, found, verdict."""


def unexpected_nodes(rig: Rig, link: Link) -> Iterator[CheckResult]:
    """Read the device type of all node ids; yields the nodes that are not in the rig file."""
    expected = {drive.node_id for drive in rig.drives}
    for node in sorted(scan_nodes(link) - expected):
        yield CheckResult(f"node {node}", "on the bus", "not in the rig file", "answers", "fine")


def scan_nodes(link: Link) -> set[int]:
    """Node ids that answer when their device type is read."""
    responders = set[int]()
    for node in _NODE_IDS:
        link.send(0x600 + node, READ_DEVICE_TYPE)
        wait = _SCAN_TIMEOUT if node == _NODE_IDS[-1] else _REQUEST_INTERVAL
        responders |= {arbitration_id - 0x580 for arbitration_id, _ in link.frames(wait)}
    return responders & {*_NODE_IDS}


def compare_with_rig(rig: Rig, axes: Sequence[CanopenAxis]) -> Iterator[CheckResult]:
    """Compare state, reference, mode, units and configuration of every drive with the rig file."""
    for axis in axes:
        yield from (CheckResult(axis.name, *row) for row in _compare(rig, axis))


def _compare(rig: Rig, axis: CanopenAxis) -> Iterator[Row]:
    configuration = dcf.configuration(axis.drive)
    present = read_dictionary(axis.drive, axis.sdo)
    dictionary = present.after(configuration)
    yield from _state(axis, dictionary)
    yield from _reference(rig, dictionary, axis.joint)
    yield from _mode(dictionary)
    yield _supply(dictionary)
    yield from _torque_source(dictionary)
    yield from _units(dictionary)
    yield from _limits(rig, axis, dictionary)
    found = readiness.findings(rig, dictionary)
    yield from _protections(dictionary, found)
    yield from ((each.what, each.expected, each.found, each.verdict) for each in found)
    with suppress(BadInput):  # which is one of the findings
        writes = [*configuration, *setup.own_writes(rig, dictionary)]
        judged = {each.row.address[0] for each in found if each.row is not None}
        # A PDO is disabled before it is mapped; only its final value is compared.
        compared = [write for write in writes if write.check and write.index not in judged]
        yield from (_object(axis, present, dictionary, write) for write in compared if not pdo.is_foreign(write))
        if foreign := ", ".join(f"{write.index:04X}h" for write in compared if pdo.is_foreign(write)):
            yield f"PDOs of another use ({foreign})", "off", "on", "will be written"


def _fine_if(condition: bool, otherwise: Verdict = "problem") -> Verdict:
    return "fine" if condition else otherwise


def _state(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[Row]:
    if not dictionary.tells_status:
        return  # which is one of the findings
    axis.read_state()
    if axis.state is None:
        text = f"statusword 0x{axis.statusword:04X} fits no state of CiA 402"
        yield "state", "a state of CiA 402", text, "problem"
        return
    code = dictionary.value((0x603F, 0))
    text = axis.state.value + (f", last error 0x{code:04X}: {axis.text_of(code)}" if code else "")
    if axis.state in (cia402.DriveState.FAULT, cia402.DriveState.FAULT_REACTION):
        yield "state", "no fault", f"{text}; remove its cause: the start of a run tries one reset", "problem"
    elif axis.power == Power.STOPPING:  # as a run leaves it that was killed
        yield "state", "not enabled by another master", f"{text}; the start of a run switches it off", "noted"
    else:
        yield "state", "not enabled by another master", text, _fine_if(not axis.has_torque)


def _reference(rig: Rig, dictionary: DriveDictionary, joint: int) -> Iterator[Row]:
    limits, drive, unit = rig.limits, dictionary.drive, rig.position_units[joint - 1]
    counts = dictionary.value((0x6064, 0))
    if counts is not None:
        pose = drive.to_position(counts)
        span = f"{limits.joint_min:g} to {limits.joint_max:g} {unit}"
        yield "joint angle", span, f"{pose:.4f} {unit}", _fine_if(limits.joint_min <= pose <= limits.joint_max)
    if drive.homed is None:
        if drive.homing is not None:
            text = f"method {drive.homing.method} (daq home); the rig file names no object that shows it (homed)"
            yield "zero reference", "homed", text, "noted"
        return
    if (data := dictionary.data.get((drive.homed.index, drive.homed.sub))) is not None:
        what = f"zero reference, {format_address(drive.homed.index, drive.homed.sub)}"
        word = int.from_bytes(data, "little")
        homed = word & drive.homed.mask != 0
        remedy = "" if homed else ": daq home" if drive.homing else ": home it with its own tool"
        yield what, f"homed: a bit of 0x{drive.homed.mask:X}", f"0x{word:X}{remedy}", _fine_if(homed)


def _mode(dictionary: DriveDictionary) -> Iterator[Row]:
    shown, mode = dictionary.value((0x6061, 0)), MODES[dictionary.drive.mode]
    if not dictionary.value((0x6502, 0)) and dictionary.drive.assume_mode:
        yield "supports its mode (6502h)", "yes", "not reported by the drive, tried (assume_mode)", "fine"
    if shown is not None:
        yield "mode that is set (6060h)", str(mode), str(shown), _fine_if(shown == mode, "will be written")


def _supply(dictionary: DriveDictionary) -> Row:
    """DC link voltage and statusword bit 4; some drives set the bit only when they are ready to switch on."""
    millivolts = dictionary.value((0x6079, 0))
    switched = (dictionary.value((STATUSWORD, 0)) or 0) & _VOLTAGE_ENABLED
    text = "on" if switched else "not reported as on (statusword bit 4)"
    link = "" if millivolts is None else f", DC link {millivolts / 1000:g} V (6079h)"
    return "supply", "on", text + link, "fine"


def _torque_source(dictionary: DriveDictionary) -> Iterator[Row]:
    drive = dictionary.drive
    if drive.torque_source == "voltage":
        yield from _voltage(dictionary)
        return
    if drive.torque_source == "none":
        yield "torque source", "none", "positions only: nothing can be identified from a recording", "noted"
        return
    # Ratings are of the motor: mA, mN m.
    if drive.torque_source == "current_actual":
        index, what, raw = 0x6078, "rated current (6075h)", dictionary.value((0x6075, 0))
        factor, given, unit = 1e-3, drive.rated_current, "A"
    else:
        index, what, raw = 0x6077, "rated torque at the joint (6076h times gear)", dictionary.value((0x6076, 0))
        factor, given, unit = 1e-3 * drive.gear, drive.rated_torque, "N m"
    assert given is not None
    name, count = f"{drive.torque_source.replace('_', ' ')} {format_address(index, 0)}", dictionary.value((index, 0))
    if count is not None:
        yield name, "readable", f"{count} = {drive.sign * count / 1000 * given:g} {unit}", "fine"
    elif (index, 0) in dictionary:
        yield name, "readable", "cannot be read", "noted"
    if raw:
        agree = math.isclose(raw * factor, given, rel_tol=readiness.RATING_TOLERANCE)
        found = f"{raw * factor:g} {unit}" + ("" if agree else ": that of the rig file counts; compare both")
        yield what, f"{given:g} {unit}", found, _fine_if(agree, "noted")
    else:
        yield what, f"{given:g} {unit}", "not stated by the drive: compare with the type plate", "noted"


def _voltage(dictionary: DriveDictionary) -> Iterator[Row]:
    voltage = dictionary.drive.voltage
    address = (voltage.index, voltage.sub)
    what, data = f"voltage object {format_address(*address)}", dictionary.data.get(address)
    if voltage.kind == "dc_link":
        yield what, "the motor's voltage", "the DC link voltage, which does not follow the torque", "problem"
    elif data:
        signed = pdo.voltage_is_signed(dictionary.drive)
        volts = int.from_bytes(data, "little", signed=signed) * voltage.scale
        kind = f"{8 * len(data)} bits, {'signed' if signed else 'unsigned'}"
        yield what, "an integer, readable", f"{volts:g} V ({kind})", "fine"


def _units(dictionary: DriveDictionary) -> Iterator[Row]:
    if doubt := readiness.position_doubt(dictionary):
        counts = f"{dictionary.drive.counts_per_turn} (counts_per_turn), assumed"
        yield "position units per motor turn", counts, doubt, "noted"
    for quantity, unit in _SI.items():
        scale = getattr(dictionary.units, quantity)
        if scale is not None:
            text = f"{scale.per_radian:.6g} {scale.name} ({scale.source})"
            yield f"1 {unit} of the joint", "as the drive understands it", text, "noted"
    code = dictionary.value((0x60A9, 0))
    if code and dictionary.units.velocity is None:
        text = f"0x{code:08X} is unknown: speeds of the drive cannot be shown, and none can be set for homing"
        yield "unit of velocity (60A9h)", "a known unit", text, "noted"


def _limits(rig: Rig, axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[Row]:
    """The drive's own largest speeds and accelerations, in SI units; a low one may slow the motion down."""
    motor_speed = Scale(axis.drive.gear / _RADIANS_PER_SECOND_PER_RPM, "rpm", "6080h")
    for index, name, scale, quantity in (
        (0x6080, "largest motor speed", motor_speed, "velocity"),
        (0x607F, "largest profile speed", dictionary.units.velocity, "velocity"),
        (0x60C5, "largest acceleration", dictionary.units.acceleration, "acceleration"),
        (0x60C6, "largest deceleration", dictionary.units.acceleration, "acceleration"),
    ):
        if scale is not None and (raw := axis.sdo.read_optional(index, 0, "<I")):
            needed = rig.limits.speed if quantity == "velocity" else rig.limits.acceleration
            largest, unit = raw / scale.per_radian, _SI[quantity]
            text, verdict = f"{raw} = {largest:.4g} {unit}", _fine_if(largest >= needed, "noted")
            yield f"{format_address(index, 0)} {name}", f"at least {needed:g} {unit}", text, verdict


def _protections(dictionary: DriveDictionary, found: Sequence[readiness.DriveFinding]) -> Iterator[Row]:
    """What protects the drive by itself, and by which objects; why one does not, its own row says."""
    watchdogs = {"guarding": "node guarding (100Ch, 100Dh)", "rpdo": "time-out of the RPDO (1400h:05)"}
    lacking = {each.row.address[0]: each.verdict for each in found if each.row is not None}
    names = {0x1016: watchdogs.get(dictionary.watchdog or "", "1016h")}
    for name, indices in zip(PROTECTIONS, _PROTECTING, strict=True):
        kept = ", ".join(names.get(index, f"{index:04X}h") for index in indices if index not in lacking)
        lost = [index for index in indices if index in lacking]
        without = f", without {', '.join(f'{index:04X}h' for index in lost)}" if lost else ""
        are_accepted = {lacking[index] for index in lost} == {"accepted"}
        yield name, "protects", f"by {kept or 'nothing'}{without}", "accepted" if are_accepted else "noted"


def _object(axis: CanopenAxis, present: DriveDictionary, dictionary: DriveDictionary, write: SdoWrite) -> Row:
    address = (write.index, write.sub)
    row = row_of(address)
    what, expected = f"{format_address(*address)} {row.meaning}", _shown(dictionary, row, write.value)
    readable = present.data.get(address)
    actual = present.value(address, write.layout) if readable else axis.sdo.read_optional(*address, write.layout)
    if actual is not None:
        is_so = not (actual ^ write.value) & write.mask
        return what, expected, _shown(dictionary, row, actual), _fine_if(is_so, "will be written")
    if axis.sdo.has(*address):
        return what, expected, "cannot be read", "will be written"
    return what, expected, "no such object", "problem"


def _shown(dictionary: DriveDictionary, row: Requirement, value: int) -> str:
    """A value as shown: of a PDO and of 1016h in hexadecimal, of a limit also in SI units as the drive understands
    it."""
    if row in (PDO, WATCHDOG):
        return f"0x{value:X}"
    scale = getattr(dictionary.units, row.quantity, None)
    return str(value) if scale is None else f"{value} = {value / scale.per_radian:.4g} {_SI[row.quantity]}"

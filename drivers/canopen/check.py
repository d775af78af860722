"""Compare CANopen drives with the rig file before anything is written, for `daq check`."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from drivers import cia402
from drivers.canopen import dcf, pdo, readiness, setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.dictionary import DriveDictionary, integer_at, read_dictionary
from drivers.canopen.node_axes import of_axis
from drivers.canopen.roles import PDO, ROLES, role_of, without
from drivers.canopen.sdo import READ_DEVICE_TYPE, ObjectRefused, SdoWrite, format_address
from drivers.eds import load_dictionary
from drivers.protocol import CheckResult, Power, Verdict
from recordings.drives import STATUSWORD
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

_SCAN_TIMEOUT = 0.3
"""Time that the scan waits for the last answer [s]."""
_REQUEST_INTERVAL = 0.0005
"""Time between two requests of the scan, so that no interface's queue overflows [s]."""
_NODE_IDS = range(1, 128)
_NOTED = (0x1006, 0x1017)
"""Objects of convenience whose absence is shown."""
_VOLTAGE_ENABLED = 0x10
"""Statusword bit 4."""
_QUANTITIES = {0x6065: "position", 0x607D: "position", 0x6084: "acceleration", 0x6085: "acceleration"}
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
    yield from _reference(rig, axis)
    yield from _mode(dictionary)
    yield _supply(dictionary)
    yield from _torque_source(dictionary)
    for watched in axis.drive.watched:
        found = axis.sdo.has(watched.index, watched.sub)
        what = f"watched object {format_address(watched.index, watched.sub)} {watched.name}".rstrip()
        yield what, "readable", "there" if found else "no such object", _fine_if(found)
    yield from _units(dictionary)
    yield from _limits(rig, axis, dictionary)
    yield from _missing(dictionary)
    try:
        writes = [*configuration, *setup.own_writes(rig, dictionary)]
    except BadInput as error:
        yield "set-up", "objects that suffice", str(error), "problem"
        return
    # A PDO is disabled before it is mapped; only its final value is compared.
    yield from (_object(axis, present, dictionary, write) for write in writes if write.check)


def _fine_if(condition: bool, otherwise: Verdict = "problem") -> Verdict:
    return "fine" if condition else otherwise


def _state(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[Row]:
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


def _reference(rig: Rig, axis: CanopenAxis) -> Iterator[Row]:
    limits, drive, unit = rig.limits, axis.drive, rig.position_units[axis.joint - 1]
    pose = drive.to_position(axis.sdo.read(0x6064, 0, "<i"))
    span = f"{limits.joint_min:g} to {limits.joint_max:g} {unit}"
    yield "joint angle", span, f"{pose:.4f} {unit}", _fine_if(limits.joint_min <= pose <= limits.joint_max)
    if drive.homed is None:
        if drive.homing is not None:
            text = f"method {drive.homing.method} (daq home); the rig file names no object that shows it (homed)"
            yield "zero reference", "homed", text, "noted"
        return
    what = f"zero reference, {format_address(drive.homed.index, drive.homed.sub)}"
    expected = f"homed: a bit of 0x{drive.homed.mask:X}"
    try:
        word = integer_at(axis.sdo, drive.homed.index, drive.homed.sub)
    except ObjectRefused:
        yield what, expected, "no such object", "problem"
        return
    homed = word & drive.homed.mask != 0
    remedy = "daq home" if drive.homing else "home it with its own tool"
    yield what, expected, f"0x{word:X}" if homed else f"0x{word:X}: {remedy}", _fine_if(homed)


def _mode(dictionary: DriveDictionary) -> Iterator[Row]:
    name = dictionary.drive.mode
    mode, problem = setup.MODES[name], readiness.mode_problem(dictionary)
    listed = "yes" if dictionary.value((0x6502, 0)) else "not reported by the drive, tried (assume_mode)"
    yield f"supports mode {mode}, {name} position (6502h)", "yes", problem or listed, _fine_if(not problem)
    shown = dictionary.value((0x6061, 0))
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
        yield _voltage(dictionary)
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
    if count is None:
        there = (index, 0) in dictionary
        yield name, "readable", *(("cannot be read", "noted") if there else ("no such object", "problem"))
    else:
        yield name, "readable", f"{count} = {drive.sign * count / 1000 * given:g} {unit}", "fine"
    if raw:
        agree = math.isclose(raw * factor, given, rel_tol=readiness.RATING_TOLERANCE)
        yield what, f"{given:g} {unit}", f"{raw * factor:g} {unit}", _fine_if(agree)
    else:
        yield what, f"{given:g} {unit}", "not stated by the drive: compare with the type plate", "noted"


def _voltage(dictionary: DriveDictionary) -> Row:
    voltage = dictionary.drive.voltage
    address = (voltage.index, voltage.sub)
    what, data = f"voltage object {format_address(*address)}", dictionary.data.get(address)
    if not data or len(data) not in (1, 2, 4):
        return what, "an integer, readable", f"{len(data)} bytes" if data else "no such object", "problem"
    if voltage.kind == "dc_link":
        return what, "the motor's voltage", "the DC link voltage, which does not follow the torque", "problem"
    signed = pdo.voltage_is_signed(dictionary.drive)
    volts = int.from_bytes(data, "little", signed=signed) * voltage.scale
    kind = f"{8 * len(data)} bits, {'signed' if signed else 'unsigned'}"
    return what, "an integer, readable", f"{volts:g} V ({kind})", "fine"


def _units(dictionary: DriveDictionary) -> Iterator[Row]:
    for problem in readiness.unit_problems(dictionary):
        what, _, text = problem.partition(": ")
        yield what, "drive and rig file agree", text, "problem"
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
    limits, velocity, acceleration = rig.limits, dictionary.units.velocity, dictionary.units.acceleration
    scales = [(0x6080, "largest motor speed", _RADIANS_PER_SECOND_PER_RPM / axis.drive.gear, "rad/s", limits.speed)]
    if velocity is not None:
        scales.append((0x607F, "largest profile speed", 1 / velocity.per_radian, "rad/s", limits.speed))
    if acceleration is not None:
        for index, name in ((0x60C5, "largest acceleration"), (0x60C6, "largest deceleration")):
            scales.append((index, name, 1 / acceleration.per_radian, "rad/s^2", limits.acceleration))
    for index, name, factor, unit, needed in scales:
        raw = axis.sdo.read_optional(index, 0, "<I")
        if raw:
            what, text = f"{format_address(index, 0)} {name}", f"{raw} = {raw * factor:.4g} {unit}"
            yield what, f"at least {needed:g} {unit}", text, _fine_if(raw * factor >= needed, "noted")


def _missing(dictionary: DriveDictionary) -> Iterator[Row]:
    for text in readiness.missing_for_motion(dictionary):
        yield text.partition(":")[0], "needed for motion", text, "problem"
    refused = readiness.not_accepted(dictionary)
    for index in readiness.missing_for_safety(dictionary):
        role = ROLES[index]
        what = f"{index:04X} {role.meaning}"
        if index in refused:
            yield what, "needed for safety", f"no such object: {without(index)}", "problem"
        else:
            yield what, "needed for safety", f"missing: {role.loss}; {role.instead}", "accepted"
    indices = {index for index, _ in dictionary.data}
    for index in _NOTED:
        if index not in indices:
            yield f"{index:04X} {ROLES[index].meaning}", "optional", "no such object, left out", "noted"
    if dictionary.watchdog not in (None, "heartbeat"):
        ways = {"guarding": "node guarding (100Ch, 100Dh)", "rpdo": "time-out of the RPDO (1400:05)"}
        yield "watchdog on the master", "heartbeat", f"{ways[str(dictionary.watchdog)]} instead of 1016h", "noted"


def _object(axis: CanopenAxis, present: DriveDictionary, dictionary: DriveDictionary, write: SdoWrite) -> Row:
    address = (write.index, write.sub)
    role = role_of(*address)
    meaning = "PDO of another use, switched off" if pdo.is_foreign(write) else role.meaning
    what = f"{format_address(*address)} {meaning}"
    readable = present.data.get(address)
    actual = present.value(address, write.layout) if readable else axis.sdo.read_optional(*address, write.layout)
    expected = _shown(dictionary, write.index, write.value, in_pdo=role is PDO)
    if actual is None:
        if axis.sdo.has(*address):
            return what, expected, "cannot be read", "will be written"
        return what, expected, "no such object", "problem"
    found = _shown(dictionary, write.index, actual, in_pdo=role is PDO)
    if not (actual ^ write.value) & write.mask:
        return what, expected, found, "fine"
    refusal = _refusal(axis.drive, write)
    if refusal and role.role != "convenience" and f"{write.index:04X}" not in axis.drive.accept_missing:
        return what, expected, f"{found}; {refusal}", "problem"
    return what, expected, found, "will be written"


def _refusal(drive: Drive, write: SdoWrite) -> str | None:
    """Why the drive will refuse a value, by the file in `eds` or `dcf`: a drive does not say its limits."""
    file = drive.eds or drive.dcf
    if file is None:
        return None
    description = of_axis(load_dictionary(Path(file), drive.node_id), drive.axis).get((write.index, write.sub))
    if description is None:
        return None
    if not description.is_writable:
        return f"{Path(file).name}: read only ({description.access})"
    low, high = description.low, description.high
    if (low is None or write.value >= low) and (high is None or write.value <= high):
        return None
    return f"{Path(file).name}: {'...' if low is None else low} to {'...' if high is None else high} allowed"


def _shown(dictionary: DriveDictionary, index: int, value: int, *, in_pdo: bool) -> str:
    """A value as shown: of a PDO in hexadecimal, of a limit also in SI units as the drive understands it."""
    if in_pdo:
        return f"0x{value:X}"
    quantity = _QUANTITIES.get(index, "")
    scale = getattr(dictionary.units, quantity, None)
    return str(value) if scale is None else f"{value} = {value / scale.per_radian:.4g} {_SI[quantity]}"

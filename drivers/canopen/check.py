"""Compare CANopen drives with the rig file before anything is written, for `daq check`."""

import math
import time
from collections.abc import Iterator, Sequence

from drivers import cia402
from drivers.canopen import dcf, pdo, readiness, setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.dictionary import DriveDictionary, integer_at, read_dictionary
from drivers.canopen.limits import refusal
from drivers.canopen.roles import ROLES, is_pdo, role_of
from drivers.canopen.sdo import ObjectRefused, SdoWrite, format_address
from drivers.protocol import CheckResult, Verdict
from recordings.drives import STATUSWORD
from recordings.errors import BadInput
from recordings.rig import Rig

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


def unexpected_nodes(rig: Rig, link: Link) -> Iterator[CheckResult]:
    """Read the device type of all node ids; yields the nodes that are not in the rig file."""
    expected = {drive.node_id for drive in rig.drives}
    for node in sorted(scan_nodes(link) - expected):
        yield CheckResult(f"node {node}", "on the bus", "not in the rig file", "answers", "fine")


def scan_nodes(link: Link) -> set[int]:
    """Node ids that answer when their device type is read."""
    responses = set()
    deadline = time.monotonic() + _SCAN_TIMEOUT
    for node in _NODE_IDS:
        link.send(0x600 + node, bytes.fromhex("4000100000000000"))
        deadline = time.monotonic() + _SCAN_TIMEOUT
        while (frame := link.receive(_REQUEST_INTERVAL)) is not None:
            responses.add(frame[0])
    while (frame := link.receive(max(0.0, deadline - time.monotonic()))) is not None:
        responses.add(frame[0])
    return {arbitration_id - 0x580 for arbitration_id in responses if arbitration_id - 0x580 in _NODE_IDS}


def compare_with_rig(rig: Rig, axes: Sequence[CanopenAxis]) -> Iterator[CheckResult]:
    """Compare state, reference, mode, units and configuration of every drive with the rig file."""
    for axis in axes:
        configuration = dcf.configuration(axis.drive)
        present = read_dictionary(axis.drive, axis.sdo)
        dictionary = present.after(configuration)
        yield from _state(axis, dictionary)
        yield from _reference(rig, axis)
        yield from _mode(axis, dictionary)
        yield _supply(axis, dictionary)
        yield from _torque_source(axis, dictionary)
        yield from _units(axis, dictionary)
        yield from _limits(rig, axis, dictionary)
        yield from _missing(axis, dictionary)
        yield from _objects(rig, axis, present, dictionary, configuration)


def _objects(
    rig: Rig,
    axis: CanopenAxis,
    present: DriveDictionary,
    dictionary: DriveDictionary,
    configuration: Sequence[SdoWrite],
) -> Iterator[CheckResult]:
    try:
        writes = [*configuration, *setup.own_writes(rig, axis.drive, dictionary)]
    except BadInput as error:
        yield CheckResult(axis.name, "set-up", "objects that suffice", str(error), "problem")
        return
    for sdo_write in writes:
        # A PDO is disabled before it is mapped; only its final value is compared.
        if sdo_write.check:
            yield _object(axis, present, dictionary, sdo_write)


def _state(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[CheckResult]:
    word = axis.sdo.read(STATUSWORD, 0, "<H")
    try:
        state = cia402.decode(word)
    except ValueError as error:
        yield CheckResult(axis.name, "state", "a state of CiA 402", str(error), "problem")
        return
    code = dictionary.value((0x603F, 0)) or 0
    text = state.value if not code else f"{state.value}, last error 0x{code:04X}: {axis.text_of(code)}"
    if state in (cia402.DriveState.FAULT, cia402.DriveState.FAULT_REACTION):
        text += "; remove its cause: the start of a run tries one reset"
        yield CheckResult(axis.name, "state", "no fault", text, "problem")
        return
    at_rest = state not in (cia402.DriveState.ENABLED, cia402.DriveState.QUICK_STOP)
    yield CheckResult(axis.name, "state", "not enabled by another master", text, "fine" if at_rest else "problem")


def _reference(rig: Rig, axis: CanopenAxis) -> Iterator[CheckResult]:
    limits, drive = rig.limits, axis.drive
    angle = drive.to_position(axis.sdo.read(0x6064, 0, "<i"))
    inside = limits.joint_min <= angle <= limits.joint_max
    span = f"{limits.joint_min:g} to {limits.joint_max:g} rad"
    yield CheckResult(axis.name, "joint angle", span, f"{angle:.4f} rad", "fine" if inside else "problem")
    if drive.homed is None:
        if drive.homing is not None:
            text = f"method {drive.homing.method} (daq home); the rig file names no object that shows it (homed)"
            yield CheckResult(axis.name, "zero reference", "homed", text, "noted")
        return
    what = f"zero reference, {format_address(drive.homed.index, drive.homed.sub)}"
    expected = f"homed: a bit of 0x{drive.homed.mask:X}"
    try:
        word = integer_at(axis.sdo, drive.homed.index, drive.homed.sub)
    except ObjectRefused:
        yield CheckResult(axis.name, what, expected, "no such object", "problem")
        return
    homed = word & drive.homed.mask != 0
    remedy = "daq home" if drive.homing else "home it with its own tool"
    text = f"0x{word:X}" if homed else f"0x{word:X}: {remedy}"
    yield CheckResult(axis.name, what, expected, text, "fine" if homed else "problem")


def _mode(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[CheckResult]:
    mode = setup.MODES[axis.drive.mode]
    problem, modes = readiness.mode_problem(dictionary), dictionary.value((0x6502, 0))
    listed = "not reported by the drive, tried (assume_mode)" if not modes else "yes"
    what = f"supports mode {mode}, {axis.drive.mode} position (6502h)"
    yield CheckResult(axis.name, what, "yes", problem or listed, "problem" if problem else "fine")
    shown = dictionary.value((0x6061, 0))
    if shown is not None:
        verdict: Verdict = "fine" if shown == mode else "will be written"
        yield CheckResult(axis.name, "mode that the drive shows (6061h)", str(mode), str(shown), verdict)


def _supply(axis: CanopenAxis, dictionary: DriveDictionary) -> CheckResult:
    """DC link voltage and statusword bit 4; some drives set the bit only when they are ready to switch on."""
    millivolts = dictionary.value((0x6079, 0))
    switched = bool((dictionary.value((STATUSWORD, 0)) or 0) & _VOLTAGE_ENABLED)
    text = "on" if switched else "not reported as on (statusword bit 4)"
    if millivolts is not None:
        text += f", DC link {millivolts / 1000:g} V (6079h)"
    return CheckResult(axis.name, "supply", "on", text, "fine")


def _torque_source(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[CheckResult]:
    drive = axis.drive
    if drive.torque_source == "voltage":
        yield _voltage(axis, dictionary)
        return
    index = 0x6077 if drive.torque_source == "torque_actual" else 0x6078
    what = f"{drive.torque_source.replace('_', ' ')} {format_address(index, 0)}"
    verdict: Verdict = "fine" if (index, 0) in dictionary else "problem"
    yield CheckResult(axis.name, what, "readable", "yes" if verdict == "fine" else "no such object", verdict)
    # Of the motor: mA, mN m.
    what, key, rated, given, unit = (
        ("rated current (6075h)", 0x6075, 1e-3, drive.rated_current, "A")
        if index == 0x6078
        else ("rated torque at the joint (6076h times gear)", 0x6076, 1e-3 * drive.gear, drive.rated_torque, "N m")
    )
    raw = dictionary.value((key, 0))
    if raw and given is not None:
        agree = math.isclose(raw * rated, given, rel_tol=readiness.RATING_TOLERANCE)
        verdict = "fine" if agree else "problem"
        yield CheckResult(axis.name, what, f"{given:g} {unit}", f"{raw * rated:g} {unit}", verdict)


def _voltage(axis: CanopenAxis, dictionary: DriveDictionary) -> CheckResult:
    voltage = axis.drive.voltage
    address = (voltage.index, voltage.sub)
    what = f"voltage object {format_address(*address)}"
    data = dictionary.data.get(address)
    if not data or len(data) not in (1, 2, 4):
        text = "no such object" if not data else f"{len(data)} bytes"
        return CheckResult(axis.name, what, "an integer, readable", text, "problem")
    if voltage.kind == "dc_link":
        return CheckResult(
            axis.name, what, "the motor's voltage", "the DC link voltage, which does not follow the torque", "problem"
        )
    signed = pdo.voltage_is_signed(axis.drive)
    volts = int.from_bytes(data, "little", signed=signed) * voltage.scale
    kind = f"{8 * len(data)} bits, {'signed' if signed else 'unsigned'}"
    return CheckResult(axis.name, what, "an integer, readable", f"{volts:g} V ({kind})", "fine")


def _units(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[CheckResult]:
    rating = readiness.rating_problem(dictionary)
    for problem in [*readiness.unit_problems(dictionary), *([rating] if rating else [])]:
        what, _, text = problem.partition(": ")
        yield CheckResult(axis.name, what, "drive and rig file agree", text, "problem")
    for quantity, unit in _SI.items():
        scale = getattr(dictionary.units, quantity)
        if scale is not None:
            text = f"{scale.per_radian:.6g} {scale.name} ({scale.source})"
            yield CheckResult(axis.name, f"1 {unit} of the joint", "as the drive understands it", text, "noted")
    code = dictionary.value((0x60A9, 0))
    if code and dictionary.units.velocity is None:
        # Nothing is written in units of velocity.
        text = f"0x{code:08X} is unknown: speeds of the drive cannot be shown"
        yield CheckResult(axis.name, "unit of velocity (60A9h)", "a known unit", text, "noted")


def _limits(rig: Rig, axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[CheckResult]:
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
            verdict: Verdict = "fine" if raw * factor >= needed else "noted"
            text = f"{raw} = {raw * factor:.4g} {unit}"
            yield CheckResult(
                axis.name, f"{format_address(index, 0)} {name}", f"at least {needed:g} {unit}", text, verdict
            )


def _missing(axis: CanopenAxis, dictionary: DriveDictionary) -> Iterator[CheckResult]:
    for text in readiness.missing_for_motion(dictionary):
        yield CheckResult(axis.name, text.partition(":")[0], "needed for motion", text, "problem")
    refused = readiness.not_accepted(dictionary)
    for index in readiness.missing_for_safety(dictionary):
        role = ROLES[index]
        what = f"{index:04X} {role.meaning}"
        if index in refused:
            text = f'no such object: {role.loss}; accept_missing = ["{index:04X}"] drives without it ({role.instead})'
            yield CheckResult(axis.name, what, "needed for safety", text, "problem")
        else:
            yield CheckResult(
                axis.name, what, "needed for safety", f"missing: {role.loss}; {role.instead}", "accepted"
            )
    indices = {index for index, _ in dictionary.data}
    for index, role in ROLES.items():
        if role.role == "convenience" and index in _NOTED and index not in indices:
            yield CheckResult(
                axis.name, f"{index:04X} {role.meaning}", "optional", "no such object, left out", "noted"
            )
    if dictionary.watchdog not in (None, "heartbeat"):
        ways = {"guarding": "node guarding (100Ch, 100Dh)", "rpdo": "time-out of the RPDO (1400:05)"}
        text = f"{ways[str(dictionary.watchdog)]} instead of 1016h"
        yield CheckResult(axis.name, "watchdog on the master", "heartbeat", text, "noted")


def _object(
    axis: CanopenAxis, present: DriveDictionary, dictionary: DriveDictionary, sdo_write: SdoWrite
) -> CheckResult:
    role, in_pdo = role_of(sdo_write.index, sdo_write.sub), is_pdo(sdo_write.index, sdo_write.sub)
    meaning = "PDO of another use, switched off" if pdo.is_foreign(sdo_write) else role.meaning
    what = f"{format_address(sdo_write.index, sdo_write.sub)} {meaning}"
    actual = _present(axis, present, sdo_write)
    if actual is None:
        expected = _shown(dictionary, sdo_write.index, sdo_write.value, in_pdo=in_pdo)
        if axis.sdo.has(sdo_write.index, sdo_write.sub):
            return CheckResult(axis.name, what, expected, "cannot be read", "will be written")
        return CheckResult(axis.name, what, expected, "no such object", "problem")
    same = not (actual ^ sdo_write.value) & sdo_write.mask
    refused = None if same else refusal(axis.drive, sdo_write)
    shown = [_shown(dictionary, sdo_write.index, value, in_pdo=in_pdo) for value in (sdo_write.value, actual)]
    if refused and role.role != "convenience" and f"{sdo_write.index:04X}" not in axis.drive.accept_missing:
        return CheckResult(axis.name, what, shown[0], f"{shown[1]}; {refused}", "problem")
    return CheckResult(axis.name, what, shown[0], shown[1], "fine" if same else "will be written")


def _present(axis: CanopenAxis, present: DriveDictionary, sdo_write: SdoWrite) -> int | None:
    address = (sdo_write.index, sdo_write.sub)
    if present.data.get(address):
        return present.value(address, sdo_write.layout)
    return axis.sdo.read_optional(*address, sdo_write.layout)


def _shown(dictionary: DriveDictionary, index: int, value: int, *, in_pdo: bool) -> str:
    """A value as shown: of a PDO in hexadecimal, of a limit also in SI units as the drive understands it."""
    if in_pdo:
        return f"0x{value:X}"
    quantity = _QUANTITIES.get(index)
    scale = None if quantity is None else getattr(dictionary.units, quantity)
    if quantity is None or scale is None:
        return str(value)
    return f"{value} = {value / scale.per_radian:.4g} {_SI[quantity]}"

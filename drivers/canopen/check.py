"""Compare CANopen drives with the rig file before anything is written, for `daq check`."""

import time
from collections.abc import Iterator, Sequence

from drivers import cia402
from drivers.canopen import setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.sdo import format_address
from drivers.protocol import CheckResult
from recordings.rig import Rig

_SCAN_TIMEOUT = 0.3
"""Time that the scan waits for the last answer [s]."""
_REQUEST_INTERVAL = 0.0005
"""Time between two requests of the scan, so that no interface's queue overflows [s]."""
_NODE_IDS = range(1, 128)
_MODE_BITS = {"cyclic": 7, "interpolated": 6}
"""Bits of object 6502 (supported drive modes)."""

_MEANINGS = {
    0x1006: "communication cycle period [us]",
    0x1016: "watchdog on the master's heartbeat",
    0x1017: "heartbeat of the drive [ms]",
    0x6007: "reaction to a lost master: quick stop",
    0x605A: "quick stop: on its ramp, then off",
    0x605E: "reaction to a fault: quick stop ramp",
    0x6060: "mode of operation",
    0x6065: "following error window [counts]",
    0x6066: "following error time-out [ms]",
    0x607D: "software position limit [counts]",
    0x6085: "quick stop deceleration [counts/s^2]",
    0x60C2: "interpolation time",
}


def unexpected_nodes(rig: Rig, link: Link) -> Iterator[CheckResult]:
    """Read the device type of all node ids; yields the nodes that are not in the rig file."""
    expected = {drive.node_id for drive in rig.drives}
    for node in sorted(_scan_nodes(link) - expected):
        yield CheckResult(f"node {node}", "on the bus", "not in the rig file", "answers", "fine")


def _scan_nodes(link: Link) -> set[int]:
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
    """Compare state, zero reference, supported modes and configuration of every drive with the rig file."""
    for axis in axes:
        yield from _state(axis)
        yield from _reference(rig, axis)
        yield _mode(axis)
        yield _voltage(axis)
        for sdo_write in setup.sdo_writes(rig, axis.drive):
            # A PDO is disabled before it is mapped; only its final value is compared.
            if sdo_write.check:
                yield _object(axis, sdo_write)


def _state(axis: CanopenAxis) -> Iterator[CheckResult]:
    word = axis.sdo.read(0x6041, 0, "<H")
    try:
        state = cia402.decode(word)
    except ValueError as error:
        yield CheckResult(axis.name, "state", "a state of CiA 402", str(error), "problem")
        return
    code = axis.sdo.read_optional(0x603F, 0, "<H") or 0
    text = state.value if not code else f"{state.value}, last error 0x{code:04X}"
    at_rest = state is not cia402.DriveState.ENABLED
    yield CheckResult(axis.name, "state", "not enabled by another master", text, "fine" if at_rest else "problem")


def _reference(rig: Rig, axis: CanopenAxis) -> Iterator[CheckResult]:
    limits, drive = rig.limits, axis.drive
    angle = drive.to_position(axis.sdo.read(0x6064, 0, "<i"))
    inside = limits.joint_min <= angle <= limits.joint_max
    span = f"{limits.joint_min:g} to {limits.joint_max:g} rad"
    yield CheckResult(axis.name, "joint angle", span, f"{angle:.4f} rad", "fine" if inside else "problem")
    if drive.homed is not None:
        word = axis.sdo.read_optional(drive.homed.index, drive.homed.sub, "<B")
        homed = word is not None and word & drive.homed.mask != 0
        address = format_address(drive.homed.index, drive.homed.sub)
        yield CheckResult(axis.name, f"zero reference, {address}", "homed", str(word), "fine" if homed else "problem")


def _mode(axis: CanopenAxis) -> CheckResult:
    modes = axis.sdo.read_optional(0x6502, 0, "<I")
    bit = _MODE_BITS[axis.drive.mode]
    what = f"supports {axis.drive.mode} position (6502 bit {bit})"
    if modes is None:
        return CheckResult(axis.name, what, "yes", "not reported by the drive", "fine")
    able = bool(modes >> bit & 1)
    return CheckResult(axis.name, what, "yes", "yes" if able else f"no (0x{modes:X})", "fine" if able else "problem")


def _voltage(axis: CanopenAxis) -> CheckResult:
    voltage = axis.drive.voltage
    what = f"voltage object {format_address(voltage.index, voltage.sub)}"
    actual = axis.sdo.read_optional(voltage.index, voltage.sub, "<h")
    if actual is None:
        return CheckResult(axis.name, what, "16 bits, readable", "no such object", "problem")
    if voltage.kind == "dc_link":
        return CheckResult(
            axis.name, what, "the motor's voltage", "the DC link voltage, which does not follow the torque", "problem"
        )
    return CheckResult(axis.name, what, "16 bits, readable", f"{actual * voltage.scale:g} V", "fine")


def _object(axis: CanopenAxis, sdo_write: setup.SdoWrite) -> CheckResult:
    meaning = _MEANINGS.get(sdo_write.index, "PDO")
    what = f"{format_address(sdo_write.index, sdo_write.sub)} {meaning}"
    actual = axis.sdo.read_optional(sdo_write.index, sdo_write.sub, sdo_write.layout)
    if actual is None:
        return CheckResult(axis.name, what, str(sdo_write.value), "no such object", "problem")
    shown = (f"0x{sdo_write.value:X}", f"0x{actual:X}") if meaning == "PDO" else (str(sdo_write.value), str(actual))
    return CheckResult(axis.name, what, *shown, "fine" if actual == sdo_write.value else "will be written")

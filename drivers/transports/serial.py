"""Serial: drives with the ASCII protocol, on one line or on one line each."""

import math
from contextlib import suppress

from drivers.canopen.bus import Tap
from drivers.protocol import Amplifiers, Goal, Power, Report
from drivers.serial.axis import SerialAxis
from drivers.serial.drive import SerialDrives
from drivers.serial.line import SerialLine
from drivers.serial.port import open_port
from drivers.serial.protocol import parse
from drivers.transports import SimulatedTime
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

_CANOPEN_OPTIONS = (
    *(
        "axis",
        "mode",
        "torque_actual",
        "torque_source",
        "rated_current",
        "homed",
        "homing",
        "dcf",
        "eds",
        "units",
    ),
    *(
        "assume_mode",
        "target_followed_bit",
        "quick_stop_option",
        "fault_reaction_option",
        "abort_option",
        "halt_option",
    ),
    "fault_reset_timeout",
)
"""Keys of [[drives]] that are for CANopen drives only."""
_ANY_STATUS = 2**32 - 1
_LONGEST_VOLTAGE = "-32768"
_LONGEST_OFFSET = -3000
"""limits.torque_offset is 3 at most [thousandths of the rated torque]."""
_LOCKSTEP_REPLY_TIMEOUT = 2.0
"""Least reply timeout with simulated time, where a late reply must not change the recording [s]."""


def cycle_time(rig: Rig) -> float:
    """Longest duration of one cycle on the lines, turnarounds included [s]."""
    axes = [SerialAxis(rig, joint) for joint in range(1, rig.dof + 1)]
    return max(_line_time(rig, [axis for axis in axes if axis.port == port]) for port in rig.serial.ports)


def highest_rate(rig: Rig) -> float:
    """The rate [Hz] at which the load of the lines reaches the limit in the rig file."""
    return rig.serial.max_load / cycle_time(rig)


def skew(rig: Rig) -> float:
    """Time between reading the first and the last drive of a line [s]."""
    if len(rig.serial.ports) > 1:
        return 0.0
    return sum(
        _exchange_time(rig, SerialAxis(rig, joint), Power.ON, with_status=False) for joint in range(1, rig.dof)
    )


def _line_time(rig: Rig, axes: list[SerialAxis]) -> float:
    """Duration of one cycle of a line [s]: a target for every drive; the status of one, which may be enabled."""
    usual = [_exchange_time(rig, axis, Power.ON, with_status=False) for axis in axes]
    longest = [
        max(_exchange_time(rig, axis, power, with_status=True) for power in (Power.ON, Power.OFF)) for axis in axes
    ]
    return sum(usual) + max(longer - shorter for longer, shorter in zip(longest, usual, strict=True))


def _exchange_time(rig: Rig, axis: SerialAxis, power: Power, *, with_status: bool) -> float:
    """Duration of the exchange with one drive [s], from the driver's commands and the longest replies to them."""
    bus = rig.serial
    position = max(map(str, rig.limits.joint_counts(axis.drive)), key=len)
    status = _ANY_STATUS & ~(bus.status.fault | bus.status.off) | (bus.status.off if power is Power.OFF else 0)
    values = {
        axis.get(bus.registers.position): position,
        axis.get(bus.registers.voltage): _LONGEST_VOLTAGE,
        axis.get(bus.registers.status): str(status),
    }
    axis.power, axis.counts, axis.answered = power, int(position), True
    axis.begin_cycle()
    script = axis.cycle(Goal.ENABLED, axis.target(int(position), _LONGEST_OFFSET), with_status)
    characters = exchanges = 0
    command = next(script)
    with suppress(StopIteration):
        while True:
            reply = f"v {values[command]}" if command in values else "ok"
            characters += len(command) + len(reply) + 2  # each with its end character
            exchanges += 1
            command = script.send(parse(reply.encode()))
    return characters * bus.character + exchanges * bus.turnaround


def check(rig: Rig) -> None:
    """See `Transport`."""
    for joint, drive in enumerate(rig.drives, start=1):
        for name in _CANOPEN_OPTIONS:
            if getattr(drive, name) != Drive.model_fields[name].default:
                raise BadInput(
                    f"'{name}' of joint {joint} is for CANopen drives and has no effect on a serial line; remove it"
                )
        if drive.torque_offset and not rig.serial.registers.torque_offset:
            raise BadInput(
                f"joint {joint}: a torque can be fed forward only to a drive with a register for it; name it as "
                "torque_offset in [bus.registers], by the drive's manual"
            )
    if rig.rate > highest_rate(rig):
        raise BadInput(
            f"at {rig.rate:g} Hz a cycle has {1e3 / rig.rate:.1f} ms, of which bus.max_load allows "
            f"{rig.serial.max_load:.0%}, and its commands and replies take up to {1e3 * cycle_time(rig):.1f} ms; "
            f"choose --rate {math.floor(highest_rate(rig))} or less, a higher baud rate, or a line for each drive"
        )


def describe(rig: Rig) -> str:
    """See `Transport`."""
    bus, time = rig.serial, cycle_time(rig)
    lines = "one line" if len(bus.ports) == 1 else f"{len(bus.ports)} lines"
    apart = f", drives are read up to {1e3 * skew(rig):.1f} ms apart" if skew(rig) else ""
    return (
        f"serial, {lines} ({', '.join(bus.ports)}) at {bus.baud} baud: a cycle takes up to {1e3 * time:.1f} ms on "
        f"the wire, {time * rig.rate:.0%} of the period{apart}; highest rate {math.floor(highest_rate(rig))} Hz"
    )


def simulated_here(rig: Rig) -> bool:
    """See `Transport`."""
    return all(port.startswith("simulated") for port in rig.serial.ports)


def lead(rig: Rig) -> float:
    """See `Transport`."""
    return 0.0


def connect(rig: Rig, report: Report, tap: Tap, clock: SimulatedTime | None) -> Amplifiers:
    """See `Transport`; there are no frames to tap."""
    bus = rig.serial
    lines: dict[str, SerialLine] = {}
    try:
        for name in bus.ports:
            port = open_port(name, bus.baud)
            lines[name] = SerialLine(port, name, bus, 0.0 if clock is None else _LOCKSTEP_REPLY_TIMEOUT)
    except BadInput:
        for line in lines.values():
            line.close()
        raise
    return SerialDrives(rig, lines, report, stamped=clock is None)

"""Configuration of a drive on a serial line: the registers to write before it moves, computed from the rig."""

from collections.abc import Iterator
from dataclasses import dataclass

from drivers.protocol import Verdict
from recordings.drives import PROTECTIONS
from recordings.rig import Drive, Rig

_LOSSES = (
    "with this program killed or the cable pulled, the joint stays powered",
    "only this program stops a joint that is blocked",
    "only this program keeps the joint within its limits",
    "a quick stop is as hard as the drive happens to be set",
)
"""What is lost without each of PROTECTIONS."""


@dataclass(frozen=True)
class RegisterValue:
    """Required value of one register before power is switched on."""

    register: str
    meaning: str
    value: int


def protections(rig: Rig, drive: Drive) -> Iterator[tuple[str, str, Verdict]]:
    """Each protection of one drive: its name, by what it acts or what is lost without it, and a verdict."""
    for (name, keys), loss in zip(PROTECTIONS.items(), _LOSSES, strict=True):
        registers = [getattr(rig.serial.registers, key) for key in keys]
        verdict: Verdict = "noted" if all(registers) else "accepted" if name in drive.accept_missing else "problem"
        remedy = f'; name {" and ".join(keys)} in [bus.registers], or accept_missing = ["{name}"] in [[drives]]'
        missing = f"missing: {loss}{remedy if verdict == 'problem' else ''}"
        yield name, f"by {', '.join(registers)}" if all(registers) else missing, verdict


def settings(rig: Rig, drive: Drive) -> list[RegisterValue]:
    """The settings of one drive, in the order in which they are written."""
    bus, names, limits = rig.serial, rig.serial.registers, rig.limits
    counts = abs(drive.counts_per_radian)
    low, high = limits.joint_counts(drive)
    table = [
        RegisterValue(
            names.following_error, "following error limit [counts]", round(limits.following_error * counts)
        ),
        RegisterValue(
            names.deceleration,
            "quick stop deceleration",
            round(limits.acceleration * counts / bus.deceleration_unit),
        ),
        RegisterValue(names.upper_limit, "software position limit [counts]", high),
        RegisterValue(names.lower_limit, "software position limit [counts]", low),
        RegisterValue(names.torque_offset, "torque offset", 0),
        *(RegisterValue(register, "as the rig file says", value) for register, value in bus.setup.items()),
        RegisterValue(names.watchdog, "watchdog on the host's commands [ms]", round(bus.watchdog_timeout * 1000)),
    ]
    return [setting for setting in table if setting.register]

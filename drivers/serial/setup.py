"""Configuration of a drive on a serial line: the registers to write before it moves, computed from the rig."""

from dataclasses import dataclass

from recordings.rig import Drive, Rig


@dataclass(frozen=True)
class RegisterValue:
    """Required value of one register before power is switched on."""

    register: str
    meaning: str
    value: int


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

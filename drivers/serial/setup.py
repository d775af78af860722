"""Configuration of a drive on a serial line: the registers to write before it moves, computed from the rig."""

from dataclasses import dataclass

from recordings.rig import Drive, Rig


@dataclass(frozen=True)
class Setting:
    """Required value of one register before power is switched on."""

    register: str
    meaning: str
    value: int


def settings(rig: Rig, drive: Drive) -> list[Setting]:
    """The settings of one drive, in the order in which they are written."""
    bus, names = rig.serial, rig.serial.registers
    counts = abs(drive.counts_per_radian)
    low, high = rig.limits.joint_counts(drive)
    table = [
        Setting(names.following_error, "following error limit [counts]", round(rig.limits.following_error * counts)),
        Setting(
            names.deceleration,
            "quick stop deceleration",
            round(rig.limits.acceleration * counts / bus.deceleration_unit),
        ),
        Setting(names.upper_limit, "software position limit [counts]", high),
        Setting(names.lower_limit, "software position limit [counts]", low),
        Setting(names.torque_offset, "torque offset", 0),
        *(Setting(register, "as the rig file says", value) for register, value in bus.setup.items()),
        Setting(names.watchdog, "watchdog on the host's commands [ms]", round(bus.watchdog_timeout * 1000)),
    ]
    return [setting for setting in table if setting.register]

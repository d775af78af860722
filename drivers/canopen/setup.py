"""Configuration of a CiA 402 drive: the objects to write before it moves, by the rig and the dictionary."""

import struct

from drivers.canopen import pdo
from drivers.canopen.dictionary import RECEIVE, SLOW_DOWN, STANDARD, DriveDictionary
from drivers.canopen.sdo import SdoWrite
from drivers.canopen.units import Scale
from drivers.eds import Address
from recordings.errors import BadInput
from recordings.rig import Rig

SYNC_ID = 0x80
MASTER_ID = 127
"""Node id under which the master sends its heartbeat."""
MASTER_HEARTBEAT = 0.05
"""Seconds between the master's heartbeats."""
MASTER_TIMEOUT_MS = 250
"""Time without a master heartbeat after which a drive stops (object 1016)."""
DRIVE_HEARTBEAT_MS = 100
_DRIVE_HEARTBEAT = 0x1017, 0
_GUARD_TIME_MS, _LIFE_TIME_FACTOR = 100, 3
_RPDO_TIMEOUT_MS = 100

MODES = {"cyclic": 8, "interpolated": 7}
"""Object 6060; a drive that has mode m sets bit m - 1 of 6502h."""
_ROUNDING = 0.05
"""Largest relative error of the quick stop deceleration by the drive's unit."""


class TooCoarse(BadInput):
    """A unit of the drive cannot hold a value; `nearest`: the nearest one that it can, which is not 0."""

    def __init__(self, text: str, nearest: float) -> None:
        super().__init__(text)
        self.nearest = nearest


def own_writes(rig: Rig, dictionary: DriveDictionary) -> list[SdoWrite]:
    """The SDO downloads that configure one drive, in order, after those of its DCF.

    Raises:
        BadInput: the rate or a limit does not fit its object, or the drive has too few PDOs.
    """
    drive = dictionary.drive
    objects = [
        *_motion_objects(rig, dictionary),
        # A run that was killed left an offset, which would act in a run without offsets.
        *([((0x60B2, 0), 0)] if dictionary.value((0x60B2, 0)) else []),
        ((0x605A, 0), drive.quick_stop_option),
        ((0x605E, 0), drive.fault_reaction_option),
        ((0x605D, 0), drive.halt_option),
        ((0x6007, 0), drive.abort_option),
        *_watchdog(dictionary),
    ]
    writes = [
        *(_sized(dictionary, address, value) for address, value in objects if address in dictionary),
        *pdo.pdo_writes(dictionary),
    ]
    for write in writes:
        try:
            struct.pack(write.layout, write.value)
        except struct.error:
            raise BadInput(
                f"{drive.address}: {write.value:.6g} does not fit object {write.index:04X}:{write.sub:02X}; "
                "check counts_per_turn, gear, zero_offset, units and the limits in the rig file"
            ) from None
    return writes


def _sized(dictionary: DriveDictionary, address: Address, value: int) -> SdoWrite:
    return SdoWrite(*address, dictionary.layout(address, STANDARD.get(address, "<H")), value)


def _motion_objects(rig: Rig, dictionary: DriveDictionary) -> list[tuple[Address, int]]:
    drive = dictionary.drive
    counts = abs(drive.counts_per_radian)
    low, high = rig.limits.joint_counts(drive)
    period, exponent = interpolation_period(rig.rate)
    objects: list[tuple[Address, int]] = [
        ((0x6060, 0), MODES[drive.mode]),
        ((0x60C2, 1), period),
        ((0x60C2, 2), exponent),
        ((0x1006, 0), round(1e6 / rig.rate)),
        ((0x6065, 0), round(rig.limits.following_error * counts)),
        ((0x6066, 0), 10),
        ((0x607D, 1), low),
        ((0x607D, 2), high),
    ]
    acceleration = dictionary.units.acceleration
    if acceleration is not None:
        deceleration = _deceleration(rig.limits.acceleration, acceleration)
        objects.append(((0x6085, 0), deceleration))
        if drive.quick_stop_option in SLOW_DOWN or drive.fault_reaction_option in SLOW_DOWN:
            objects.append(((0x6084, 0), deceleration))
    return objects


def _deceleration(limit: float, unit: Scale) -> int:
    """`limit` [rad/s^2] in the drive's unit.

    Raises:
        TooCoarse: the unit is.
    """
    value = max(1, round(limit * unit.per_radian))
    nearest = value / unit.per_radian
    if abs(nearest - limit) > _ROUNDING * limit:
        raise TooCoarse(
            f"limits.acceleration = {limit:g} rad/s^2 cannot be written in the drive's unit ({unit.name}, "
            f"{unit.source}), the nearest is {nearest:g}; choose a finer unit in the drive, or another limit",
            nearest,
        )
    return value


def _watchdog(dictionary: DriveDictionary) -> list[tuple[Address, int]]:
    """Objects that let the drive notice a lost master, and the host a lost drive. A drive that is guarded produces no
    heartbeat: CiA 301 allows one of both."""
    heartbeat = (_DRIVE_HEARTBEAT, DRIVE_HEARTBEAT_MS)
    return {
        "heartbeat": [heartbeat, ((0x1016, 1), MASTER_ID << 16 | MASTER_TIMEOUT_MS)],
        "guarding": [(_DRIVE_HEARTBEAT, 0), ((0x100C, 0), _GUARD_TIME_MS), ((0x100D, 0), _LIFE_TIME_FACTOR)],
        "rpdo": [heartbeat, ((RECEIVE, 5), _RPDO_TIMEOUT_MS)],
        None: [heartbeat],
    }[dictionary.watchdog]


def watchdog_off(dictionary: DriveDictionary) -> list[SdoWrite]:
    """The SDO downloads that make a drive expect no master any more; its own heartbeat goes on."""
    addresses = [address for address, _ in _watchdog(dictionary) if address != _DRIVE_HEARTBEAT]
    return [_sized(dictionary, address, 0) for address in reversed(addresses)]


def interpolation_period(rate: float) -> tuple[int, int]:
    """Object 60C2 for a rate [Hz]: period = value * 10**exponent seconds, value in 1 ... 255.

    Raises:
        BadInput: the period has no such representation.
    """
    for exponent in range(-3, -7, -1):
        value = 10.0**-exponent / rate
        if 0.5 < value < 255.5 and abs(value - round(value)) < 1e-6 * value:
            return round(value), exponent
    raise BadInput(
        f"a period of 1/{rate:g} s cannot be written to object 60C2 (1 ... 255 times a power of ten); "
        "choose a rate such as 200, 250, 400, 500 or 1000 Hz"
    )

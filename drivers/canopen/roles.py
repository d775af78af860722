"""Roles of the objects that the set-up writes: what a drive without one of them can still do."""

from dataclasses import dataclass
from typing import Literal

Role = Literal["motion", "safety", "convenience"]


@dataclass(frozen=True)
class ObjectRole:
    """Role of one object."""

    role: Role
    meaning: str
    loss: str = ""
    """For safety: what no longer protects."""
    instead: str = ""
    """For safety: what the host supervises instead."""
    key: str = ""
    """Key of [[drives]] that sets its value."""


_FOLLOWING = "the host stops all drives at limits.following_error, a cycle later"

ROLES: dict[int, ObjectRole] = {
    0x6041: ObjectRole("motion", "statusword"),
    0x6060: ObjectRole("motion", "mode of operation", key="mode"),
    0x607A: ObjectRole("motion", "target position"),
    0x60B2: ObjectRole("motion", "torque offset [thousandths of the rated torque]", key="torque_offset"),
    0x60C1: ObjectRole("motion", "interpolated target"),
    0x60C2: ObjectRole("motion", "interpolation time"),
    0x6064: ObjectRole("motion", "position actual"),
    0x1006: ObjectRole("convenience", "communication cycle period [us]"),
    0x1017: ObjectRole("convenience", "heartbeat of the drive [ms]"),
    0x100C: ObjectRole("convenience", "node guarding: guard time [ms]"),
    0x100D: ObjectRole("convenience", "node guarding: life time factor"),
    0x6084: ObjectRole("convenience", "slow down ramp"),
    0x1016: ObjectRole(
        "safety",
        "watchdog on the master",
        "the drive does not stop when this program or the cable fails",
        "nothing can: only the emergency stop remains",
    ),
    0x6065: ObjectRole(
        "safety", "following error window", "the drive does not watch its following error", _FOLLOWING
    ),
    0x6066: ObjectRole(
        "safety", "following error time-out [ms]", "the drive reacts to a following error in its own time", _FOLLOWING
    ),
    0x607D: ObjectRole(
        "safety",
        "software position limit",
        "the drive follows a target beyond the joint limits",
        "the host checks every motion before it starts",
    ),
    0x605A: ObjectRole(
        "safety",
        "quick stop: on a ramp, then off",
        "a quick stop may coast, or stop as hard as the drive can",
        "the host waits for standstill before it switches off",
        "quick_stop_option",
    ),
    0x605D: ObjectRole(
        "safety",
        "reaction to halt",
        "a halt may coast",
        "the host never commands a halt",
        "halt_option",
    ),
    0x605E: ObjectRole(
        "safety",
        "reaction to a fault",
        "a drive with a fault may coast, or stop as hard as it can",
        "the host stops the other drives",
        "fault_reaction_option",
    ),
    0x6007: ObjectRole(
        "safety",
        "reaction to a lost master",
        "the drive may keep moving when this program or the cable fails",
        "nothing can: only the emergency stop remains",
        "abort_option",
    ),
    0x6085: ObjectRole(
        "safety",
        "quick stop deceleration",
        "a quick stop has the deceleration that is set in the drive",
        "the host waits for standstill before it switches off",
    ),
}

PDO = ObjectRole("motion", "PDO")
_RPDO_TIMEOUT = ObjectRole("convenience", "RPDO time-out [ms]")
_DCF = ObjectRole("motion", "from the DCF")
PDOS = range(0x1400, 0x1C00)
"""Indices of parameters and mappings."""


def role_of(index: int, sub: int) -> ObjectRole:
    """Role of an object of the set-up."""
    if index in PDOS:
        return _RPDO_TIMEOUT if (index, sub) == (0x1400, 5) else PDO
    return ROLES.get(index, _DCF)


def without(index: int) -> str:
    """What is lost without an object of safety, and how the rig file accepts that."""
    role = ROLES[index]
    return f'{role.loss}; accept_missing = ["{index:04X}"] drives without it ({role.instead})'

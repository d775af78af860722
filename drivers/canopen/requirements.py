"""What a run needs of a drive: a row for each object, with its role, type, use, and the value that the rig wants.

`daq rig propose`, `daq check`, the set-up and the run judge a drive by this table, each with what it knows of it.
"""

from collections.abc import Callable
from itertools import chain
from typing import TYPE_CHECKING

from drivers.canopen.requirement import Requirement, Wanted
from drivers.eds import Address
from recordings.drives import STATUSWORD
from recordings.errors import BadInput

if TYPE_CHECKING:
    from drivers.canopen.dictionary import DriveDictionary
    from drivers.canopen.units import Scale
    from recordings.rig import Rig

SYNC_ID = 0x80
MASTER_ID = 127
"""Node id under which the master sends its heartbeat."""
MASTER_HEARTBEAT = 0.05
"""Seconds between the master's heartbeats."""
DRIVE_HEARTBEAT_MS = 100
MASTER_TIMEOUT_MS = 250
"""Time without a master heartbeat after which a drive stops."""
_GUARD_TIME_MS, _LIFE_TIME_FACTOR = 100, 3
_RPDO_TIMEOUT_MS = 100
_FOLLOWING_ERROR_MS = 10
MODES = {"cyclic": 8, "interpolated": 7}
"""Object 6060; a drive that has mode m sets bit m - 1 of 6502h."""
SLOW_DOWN = (1, 5)
"""Option codes that stop on 6084 instead of 6085."""
_ROUNDING = 0.05
"""Largest relative error of the quick stop deceleration by the drive's unit."""


class TooCoarse(BadInput):
    """A unit of the drive cannot hold a value; `nearest`: the nearest one that it can, which is not 0."""

    def __init__(self, text: str, nearest: float) -> None:
        super().__init__(text)
        self.nearest = nearest


def _deceleration(limit: float, unit: "Scale | None") -> int | None:
    """`limit` [rad/s^2] in the drive's unit; None: it is not known.

    Raises:
        TooCoarse: the unit is.
    """
    if unit is None:
        return None
    value = max(1, round(limit * unit.per_radian))
    nearest = value / unit.per_radian
    if abs(nearest - limit) > _ROUNDING * limit:
        raise TooCoarse(
            f"limits.acceleration = {limit:g} rad/s^2 cannot be written in the drive's unit ({unit.name}, "
            f"{unit.source}), the nearest is {nearest:g}; choose a finer unit in the drive, or another limit",
            nearest,
        )
    return value


def _slow_down(rig: "Rig", dictionary: "DriveDictionary") -> int | None:
    return _deceleration(rig.limits.acceleration, dictionary.units.acceleration) if dictionary.slows_down else None


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


def _limit(end: int) -> Wanted:
    return lambda rig, dictionary: rig.limits.joint_counts(dictionary.drive)[end]


def heartbeat_value() -> int:
    """Object 1016: whose heartbeat a drive expects, and for how long it waits for one."""
    return MASTER_ID << 16 | MASTER_TIMEOUT_MS


def _period(end: int) -> Wanted:
    return lambda rig, dictionary: interpolation_period(rig.rate)[end]


def _option(key: str) -> Wanted:
    return lambda rig, dictionary: int(getattr(dictionary.drive, key))


def _where(index: int, sub: int) -> "Callable[[DriveDictionary], bool]":
    return lambda dictionary: (index, sub) in dictionary


def _always(value: int) -> Wanted:
    return lambda rig, dictionary: value


def _never(dictionary: "DriveDictionary") -> bool:
    return False


RPDO_TIMEOUT = 0x1400, 5
_FOLLOWING = "the host stops all drives at limits.following_error, a cycle later"
_POWERLESS = "nothing can: only the emergency stop remains"
_STANDSTILL = "the host waits for standstill before it switches off"

_OPTIONS = (
    (
        *(0x605A, "quick_stop_option", "quick stop: on a ramp, then off"),
        *("a quick stop may coast, or stop as hard as the drive can", _STANDSTILL),
    ),
    (
        *(0x605E, "fault_reaction_option", "reaction to a fault"),
        *("a drive with a fault may coast, or stop as hard as it can", "the host stops the other drives"),
    ),
    (0x605D, "halt_option", "reaction to halt", "a halt may coast", "the host never commands a halt"),
    (
        *(0x6007, "abort_option", "reaction to a lost master"),
        *("the drive may keep moving when this program or the cable fails", _POWERLESS),
    ),
)
"""Reactions: index, key of [[drives]], meaning, what is lost without it, and what the host does instead."""

WATCHDOG = Requirement(
    (0x1016, 1),
    "<I",
    "safety",
    "watchdog on the master",
    "w",
    lambda rig, dictionary: heartbeat_value(),
    lambda dictionary: dictionary.watchdog in (None, "heartbeat"),
    loss="the drive does not stop when this program or the cable fails",
    instead=_POWERLESS,
)
WATCHDOGS = {
    "heartbeat": (WATCHDOG,),
    "guarding": (
        Requirement(
            (0x100C, 0), "<H", "convenience", "node guarding: guard time [ms]", "w", _always(_GUARD_TIME_MS), _never
        ),
        Requirement(
            (0x100D, 0),
            "<B",
            "convenience",
            "node guarding: life time factor",
            "w",
            _always(_LIFE_TIME_FACTOR),
            _never,
        ),
    ),
    "rpdo": (
        Requirement(RPDO_TIMEOUT, "<H", "convenience", "RPDO time-out [ms]", "w", _always(_RPDO_TIMEOUT_MS), _never),
    ),
}
"""What lets a drive notice a lost master, by the way in which it does."""

TABLE = (
    Requirement((0x1000, 0), "<I", "motion", "device type", needed=_never),
    Requirement((0x6040, 0), "<H", "motion", "controlword", "mw"),
    Requirement((STATUSWORD, 0), "<H", "motion", "statusword", "rm"),
    Requirement(
        (0x6060, 0), "<b", "motion", "mode of operation", "w", lambda rig, dictionary: MODES[dictionary.drive.mode]
    ),
    *(
        Requirement((0x60C2, sub), layout, "motion", "interpolation time", "w", _period(sub - 1), _where(0x60C2, sub))
        for sub, layout in ((1, "<B"), (2, "<b"))
    ),
    Requirement(
        (0x1006, 0),
        "<I",
        "convenience",
        "communication cycle period [us]",
        "w",
        lambda rig, dictionary: round(1e6 / rig.rate),
    ),
    Requirement(
        (0x6065, 0),
        "<I",
        "safety",
        "following error window",
        "w",
        lambda rig, dictionary: round(rig.limits.following_error * abs(dictionary.drive.counts_per_radian)),
        quantity="position",
        words=r"(following|tracking|position).{0,12}(error|deviation)",
        loss="the drive does not watch its following error",
        instead=_FOLLOWING,
    ),
    Requirement(
        (0x6066, 0),
        "<H",
        "safety",
        "following error time-out [ms]",
        "w",
        _always(_FOLLOWING_ERROR_MS),
        quantity="time",
        loss="the drive reacts to a following error in its own time",
        instead=_FOLLOWING,
    ),
    *(
        Requirement(
            (0x607D, sub),
            "<i",
            "safety",
            f"{end} software position limit",
            "w",
            _limit(sub - 1),
            quantity="position",
            opposite=opposite,
            loss="the drive follows a target beyond the joint limits",
            instead="the host checks every motion before it starts",
        )
        for sub, end, opposite in (
            (1, "lower", "max|maximum|maximal|upper|positive|plus"),
            (2, "upper", "min|minimum|minimal|lower|negative|minus"),
        )
    ),
    Requirement(
        (0x6085, 0),
        "<I",
        "safety",
        "quick stop deceleration",
        "w",
        lambda rig, dictionary: _deceleration(rig.limits.acceleration, dictionary.units.acceleration),
        quantity="acceleration",
        loss="a quick stop has the deceleration that is set in the drive",
        instead=_STANDSTILL,
    ),
    Requirement((0x6084, 0), "<I", "convenience", "slow down ramp", "w", _slow_down, _never, "acceleration"),
    Requirement(  # a run that was killed left an offset, which would act in a run without offsets
        (0x60B2, 0),
        "<h",
        "motion",
        "torque offset",
        "mw",
        lambda rig, dictionary: 0 if dictionary.value((0x60B2, 0)) else None,
        lambda dictionary: dictionary.drive.torque_offset,
        "torque",
        instead="drop --feedforward",
        key="torque_offset",
    ),
    *(
        Requirement((index, 0), "<h", "safety", meaning, "w", _option(key), loss=loss, instead=instead, key=key)
        for index, key, meaning, loss, instead in _OPTIONS
    ),
    Requirement(
        (0x1017, 0),
        "<H",
        "convenience",
        "heartbeat of the drive [ms]",
        "w",
        # CiA 301 allows one of both: a drive that is guarded produces none.
        lambda rig, dictionary: 0 if dictionary.watchdog == "guarding" else DRIVE_HEARTBEAT_MS,
    ),
    *chain.from_iterable(WATCHDOGS.values()),
    Requirement(
        (0x6064, 0),
        "<i",
        "motion",
        "position actual",
        "rm",
        quantity="position",
        likewise=((0x6063, 0),),
        words="actual.{0,12}position|position.{0,12}actual",
    ),
    Requirement(
        (0x607A, 0),
        "<i",
        "motion",
        "target position",
        "m",
        needed=lambda dictionary: dictionary.drive.mode == "cyclic",
        quantity="position",
    ),
    Requirement(
        (0x60C1, 1),
        "<i",
        "motion",
        "interpolated target",
        "m",
        needed=lambda dictionary: dictionary.drive.mode == "interpolated",
    ),
    Requirement(
        (0x6077, 0),
        "<h",
        "motion",
        "torque actual",
        "m",
        quantity="torque",
        needed=lambda dictionary: (
            dictionary.drive.measures_effort and dictionary.drive.torque_source != "current_actual"
        ),
    ),
    Requirement(
        (0x6078, 0),
        "<h",
        "motion",
        "current actual",
        "m",
        quantity="current",
        needed=lambda dictionary: dictionary.drive.torque_source == "current_actual",
    ),
    *(
        Requirement((index, 0), layout, "convenience", meaning, needed=_never)
        for index, layout, meaning in (
            (0x603F, "<H", "error code"),
            (0x6061, "<b", "mode that is set"),
            (0x6075, "<I", "rated current [mA]"),
            (0x6076, "<I", "rated torque [mN m]"),
            (0x6079, "<I", "DC link voltage [mV]"),
            (0x6502, "<I", "supported modes"),
        )
    ),
)
"""In the order in which the set-up writes."""

ROWS = {row.address: row for row in TABLE}
STANDARD = {row.address: row.layout for row in TABLE}
"""Standard types of the objects, as struct formats."""
PDO = Requirement((0x1400, 1), "<I", "motion", "PDO")
_DCF = Requirement((0, 0), "<I", "motion", "from the DCF")
PDOS = range(0x1400, 0x1C00)
"""Indices of parameters and mappings."""


def row_of(address: Address) -> Requirement:
    """The row of an object that the set-up writes."""
    return ROWS.get(address) or (PDO if address[0] in PDOS else _DCF)

"""The section [[drives]] of the rig description: one amplifier and its joint."""

import math
from typing import Annotated, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, model_validator

from recordings.config import ConfigSection, Positive

NodeId = Annotated[int, Field(ge=1, le=127)]
Number = TypeVar("Number", float, NDArray[np.float64])
STATUSWORD = 0x6041
ACCELERATION_UNITS = ("counts/s^2", "rpm/s", "rev/s^2", "rad/s^2", "deg/s^2")
"""Units of acceleration that the rig file may state."""


def _acceleration_unit(text: str) -> str:
    factor, _, unit = text.rpartition(" ")
    try:
        if unit in ACCELERATION_UNITS and 0 < float(factor or 1) < math.inf:
            return text
    except ValueError:
        pass
    raise ValueError(f"{', '.join(ACCELERATION_UNITS)}, or a factor and one of these expected, '{text}' found")


PROTECTIONS = {
    "watchdog": ("watchdog",),
    "following error": ("following_error",),
    "position limits": ("upper_limit", "lower_limit"),
    "quick stop ramp": ("deceleration",),
}
"""What protects a drive on a serial line by itself, with the keys of [bus.registers] by which it does."""


def _protection(text: str) -> str:
    if text in PROTECTIONS:
        return text
    if len(text) != 4 or not set(text.upper()) <= set("0123456789ABCDEF"):
        names = ", ".join(PROTECTIONS)
        raise ValueError(f"one of {names}, or the index of an object such as 6066 expected, '{text}' found")
    return text.upper()


Protection = Annotated[str, AfterValidator(_protection)]
"""One of PROTECTIONS, or the index of an object, as printed in manuals."""


class Voltage(ConfigSection):
    """The object that holds the motor's operating voltage."""

    index: Annotated[int, Field(ge=0x2000, le=0x9FFF)] = 0x2200
    sub: Annotated[int, Field(ge=0, le=254)] = 1
    scale: Positive = 0.0005
    """Voltage per count [V]."""
    signed: bool | None = None
    """Whether the object is signed; None: by the standard where that defines it, otherwise yes. Its size is read from
    the drive."""
    kind: Literal["motor", "command", "dc_link"] = "motor"
    """Voltage across the motor; voltage commanded to the amplifier, before dead band and saturation; or supply
    voltage, which carries no information about the torque."""
    transfer: Literal["pdo", "sdo"] = "pdo"
    """Sent with SYNC (pdo), or polled where a drive cannot map the object (sdo): slower, one timestamp per value."""


class HomedBit(ConfigSection):
    """Object that indicates whether a drive is homed: `(object & mask) != 0`."""

    index: Annotated[int, Field(ge=0x2000, le=0x9FFF)]
    """0x6041 for bits of the statusword, e.g. with mask = 0x8000."""
    sub: Annotated[int, Field(ge=0, le=254)] = 0
    mask: Annotated[int, Field(gt=0, lt=2**32)] = 1

    @model_validator(mode="after")
    def _check_mask(self) -> Self:
        if self.index == STATUSWORD and self.mask >= 2**16:
            raise ValueError(f"a mask of the 16-bit statusword (1 to 0xFFFF) expected, 0x{self.mask:X} found")
        return self


class WatchedObject(ConfigSection):
    """Integer object that is polled, and whose changes are recorded as events."""

    index: Annotated[int, Field(ge=0x1000, le=0x9FFF)]
    """0x60B9 and 0x60BA to 0x60BD for a touch probe; that of the maker for Safe Torque Off."""
    sub: Annotated[int, Field(ge=0, le=254)] = 0
    mask: Annotated[int, Field(gt=0, lt=2**32)] | None = None
    """The bits that count; None: the number, which is signed."""
    name: str = ""
    """What events call it."""


class Homing(ConfigSection):
    """Search of the zero by the drive itself (CiA 402 mode 6), for `daq home`."""

    method: Annotated[int, Field(ge=-128, le=127)]
    """Object 6098, by the manual: 35 or 37 take the present position as zero, 17 and 18 search a limit switch."""
    speed: Positive | None = None
    """Speed of the search for the switch [rad/s]; None: as set in the drive (6099:01)."""
    zero_speed: Positive | None = None
    """Speed of the search for the zero [rad/s]; None: as set in the drive (6099:02)."""
    acceleration: Positive | None = None
    """[rad/s^2]; None: as set in the drive (609A)."""
    timeout: Positive = 60.0
    """Longest duration [s]."""


class AssumedUnits(ConfigSection):
    """Units of a drive that it does not state itself (60AAh)."""

    acceleration: Annotated[str, AfterValidator(_acceleration_unit)] | None = None
    """Of the quick stop deceleration (6085h): "counts/s^2" (of the motor), "rpm/s", "rev/s^2", "rad/s^2" or "deg/s^2"
    (of the motor, or of the shaft behind the gear that 6091h of the drive states); a factor may precede it, as in
    "0.001 rpm/s"."""


class Drive(ConfigSection):
    """One amplifier and its joint; joints are numbered in the order of the file."""

    node_id: NodeId
    axis: Annotated[int, Field(ge=1, le=4)] = 1
    """Axis of a node that has several, on CANopen: the objects of axis 2 stand at 6800h instead of 6000h, those of
    axis 3 at 7000h; its PDOs are 65 to 128. Objects of the manufacturer are named as they stand on the node."""
    counts_per_turn: Annotated[int, Field(gt=0)] = 8192
    """Encoder counts per turn of the motor."""
    counts_source: Literal["assumed", "measured"] = "assumed"
    """"measured": the joint was seen to move as far as commanded, by eye (`daq jog`) or by `daq axis-check`. `daq
    record` asks for it where 608Fh of the drive contradicts 6091h and 6092h."""
    gear: Positive = 21.0
    """Motor turns per turn of the joint."""
    sign: Literal[1, -1] = 1
    """-1 where counts decrease in the positive direction of the joint (which lifts the elbow)."""
    zero_offset: float = 0.0
    """Joint angle at encoder position zero [rad]."""
    voltage: Voltage = Voltage()
    mode: Literal["cyclic", "interpolated"] = "cyclic"
    """Cyclic synchronous position (mode 8), or interpolated position (mode 7) for drives without mode 8."""
    torque_actual: bool = False
    """Whether object 6077 is recorded too, in a second TPDO."""
    homed: HomedBit | None = None
    """Object that indicates a valid zero; None: always valid (absolute encoder)."""
    homing: Homing | None = None
    """How the drive searches its zero; None: absolute encoder, nothing to search."""
    watched: tuple[WatchedObject, ...] = ()
    """States that are recorded beside the motion, on CANopen: touch probe, Safe Torque Off. They are polled by SDO,
    one object of one drive after the other, and so are voltages with `transfer = "sdo"`: less often then."""
    dcf: str | None = None
    """Device configuration file (CiA 306), relative to the working folder; its values are written first."""
    eds: str | None = None
    """Object dictionary of the drive (EDS), relative to the working folder: `daq check` compares what will be written
    with its limits, which no drive tells; None: those of the DCF."""
    emcy: dict[str, str] = Field(default_factory=dict)
    """Texts of manufacturer-specific error codes, e.g. { "FF01" = "brake resistor too hot" }."""
    rated_torque: Positive = 20.0
    """Joint torque at rated current [N m]; object 6077 is in thousandths of it."""
    rated_current: Positive | None = None
    """Rated current of the motor [A]; object 6078 is in thousandths of it."""
    torque_offset: bool = False
    """Whether the torque offset (object 60B2, thousandths of the rated torque) is sent with every target; `daq record
    --feedforward` sets it. On a serial line: whether the register torque_offset is written."""
    torque_source: Literal["voltage", "torque_actual", "current_actual", "none"] = "voltage"
    """What the torque is found from: the motor's voltage by the torque map; torque actual (6077) times rated_torque;
    or current actual (6078) times rated_current and torque.per_ampere, which are recorded as effort; none: positions
    only, for commissioning."""
    units: AssumedUnits = AssumedUnits()
    accept_missing: tuple[Protection, ...] = ()
    """Protections that this drive lacks and the rig is driven without: objects of safety such as ["6066"] on CANopen;
    on a serial line "watchdog", "following error", "position limits" or "quick stop ramp". See `daq check`."""
    assume_mode: bool = False
    """Whether to try `mode` on a drive that does not list its modes (6502h absent or 0)."""
    target_followed_bit: bool = True
    """Whether bit 12 of the statusword says that the drive follows its target; false for a drive that leaves it at 0:
    then only the following error shows it."""
    quick_stop_option: Literal[1, 2, 5, 6] = 2
    """Object 605A: stop on the slow down ramp (1, 5) or the quick stop ramp (2, 6); 5 and 6 stay powered at rest, and
    are then switched off by the host."""
    fault_reaction_option: Literal[0, 1, 2] = 2
    """Object 605E: power off at once (0), or stop on the slow down ramp (1) or the quick stop ramp (2)."""
    abort_option: Literal[1, 2, 3] = 3
    """Object 6007, the reaction to a lost master: fault (1), power off (2) or quick stop (3)."""
    halt_option: Literal[1, 2, 3, 4] = 2
    """Object 605D."""
    fault_reset_timeout: Positive = 1.0
    """Longest time that the drive may take to reset a fault [s]."""

    @model_validator(mode="after")
    def _check_torque_offset(self) -> Self:
        if self.torque_offset and self.mode != "cyclic":
            raise ValueError(
                f'torque_offset needs mode = "cyclic" (mode 8), "{self.mode}" found: mode 7 has no 60B2h'
            )
        return self

    @property
    def address(self) -> str:
        """Node id, and the axis unless it is the first one."""
        return f"node {self.node_id}" + (f" axis {self.axis}" if self.axis > 1 else "")

    @property
    def measures_effort(self) -> bool:
        """Whether the drive sends its torque or current."""
        return self.torque_actual or self.torque_source in ("torque_actual", "current_actual")

    @property
    def counts_per_radian(self) -> float:
        """Signed encoder counts per radian of the joint."""
        return self.sign * self.counts_per_turn * self.gear / (2 * math.pi)

    def to_counts(self, position: Number) -> Number:
        """Encoder counts, not rounded, at a joint position [rad]."""
        return (position - self.zero_offset) * self.counts_per_radian

    def to_position(self, counts: Number) -> Number:
        """Joint position [rad] at an encoder position [counts]."""
        return self.zero_offset + counts / self.counts_per_radian

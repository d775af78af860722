"""Habits of a simulated drive: what a dictionary does not say about the drive that has it."""

import tomllib
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field

from recordings.config import ConfigSection, Positive, validated
from recordings.errors import BadInput

NotNegative = Annotated[float, Field(ge=0)]
Word = Annotated[int, Field(ge=0, le=0xFFFF)]


Trouble = Literal[
    "short_tpdo",
    "long_tpdo",
    "nmt_stop",
    "pre_operational",
    "silent_fault",
    "sync_loss",
    "limit_switch",
    "quick_stop",
    "flicker",
    "turn_lost",
    "quiet_reboot",
    "bus_off",
]
ObjectAddress = Annotated[str, Field(pattern="^[0-9A-Fa-f]{4}(:[0-9A-Fa-f]{1,2})?$")]
"""Address as in manuals: "60C2:01", or "605A" for sub-index 0."""


def parse_address(text: str) -> tuple[int, int]:
    """Index and sub-index of an `ObjectAddress`."""
    index, _, sub = text.partition(":")
    return int(index, 16), int(sub or "0", 16)


class Habits(ConfigSection):
    """Behaviour of one drive."""

    values: dict[ObjectAddress, int] = Field(default_factory=dict)
    """Values at power-on of objects, in place of those of the file."""
    allowed: dict[ObjectAddress, tuple[int, ...]] = Field(default_factory=dict)
    """The only values that an object accepts; others are aborted with 06090030h."""
    refuse_read: tuple[ObjectAddress, ...] = ()
    """Objects of the file that cannot be read (abort 08000020h)."""
    refuse_write: tuple[ObjectAddress, ...] = ()
    """Objects of the file that cannot be written (abort 08000020h)."""
    cob_id_bits: Annotated[int, Field(ge=0, lt=2**32)] = 0
    """Bits that are always set when a COB-ID of a PDO is read, e.g. 0x40000000."""
    fault_reset: NotNegative = 0.0
    """Time from the rising edge of the fault reset to its effect [s]."""
    reset_after_heartbeat_loss: bool = True
    """False: after EMCY 8130h a fault reset has no effect until NMT "reset communication"."""
    fault_on_heartbeat_loss: bool = False
    """True: a lost master is a fault whatever object 6007h says."""
    fault_at_power_on: Word = 0
    """Error code of a fault that is there when the drive is switched on; 0: none."""
    enabling: NotNegative = 0.0
    """Time from "Enable operation" to its effect, such as a brake needs [s]."""
    referenced_mask: Word = 0
    """Statusword bits that say that the drive has its zero reference."""
    referenced: bool = True
    """Whether it has it when the drive is switched on."""
    home_distance: NotNegative = 0.02
    """Distance from the pose at power-on to the home switch [rad]; methods 35 and 37 do not search."""
    trouble: Trouble | Literal["none"] = "none"
    """What happens while the drive has power. Its TPDOs lose their last byte (short_tpdo) or have one more; another
    master stops it by NMT (nmt_stop), or it goes to pre-operational; it has a fault 2310h without EMCY (silent_fault)
    or 8700h (sync_loss); it stops at a limit switch, or by a quick stop of its own; one statusword in ten says
    "switched on" (flicker); its encoder loses a turn of the motor (turn_lost); it restarts without a boot-up message
    (quiet_reboot); or errors cut it off from the bus (bus_off)."""
    trouble_after: NotNegative = 3.0
    """Time from power to that [s]."""
    turns_off: int = 0
    """Turns of the motor by which its encoder is wrong from the end of the first run on, as if it had lost its count
    while the drive was off."""
    voltage: ObjectAddress | None = None
    """Object that holds the motor's voltage; None: that of the rig file, if it is a manufacturer's object."""
    voltage_scale: Positive | None = None
    """Voltage per count [V]; None: that of the rig file."""
    counts_per_turn: Annotated[int, Field(gt=0)] | None = None
    """Encoder increments per turn of the motor; None: object 608Fh, or the rig file where it says nothing."""
    velocity_factor: Positive = 1.0
    """Velocity actual (606Ch) over what the unit that the drive states (60A9h) would give."""
    position_in_increments: bool = False
    """True: 6091h and 6092h are as they were delivered, and positions count encoder increments whatever they say."""
    gear: Positive | None = None
    """Motor turns per turn of the joint; None: that of the rig file."""


def habits_from(settings: Sequence[str], base: Habits) -> Habits:
    """`base` with the settings KEY=VALUE of a command line, each a line of TOML.

    Raises:
        BadInput: a setting is no TOML, its key is unknown, or its value is of the wrong type.
    """
    try:
        changes: dict[str, Any] = tomllib.loads("\n".join(settings))
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"--habit: KEY=VALUE as in TOML expected, found {' '.join(settings)!r} ({error})") from None
    return validated(base.model_dump(mode="json") | changes, Habits, "--habit")

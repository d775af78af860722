"""Homing of one drive by itself (CiA 402 mode 6): its objects, its start, and what it says about it."""

from enum import Enum

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.dictionary import DriveDictionary
from drivers.canopen.requirements import MODES
from drivers.canopen.sdo import SdoWrite
from drivers.canopen.units import Scale
from recordings.errors import BadInput
from recordings.rig import Homing

MODE = 6
_AT_REST, _ATTAINED, _ERROR = 0x0400, 0x1000, 0x2000
"""Statusword bits 10, 12 and 13 in homing mode."""
_START_TIME = 0.5
"""Time after the start for which "attained" may still be that of an earlier homing [s]."""


class HomingState(Enum):
    """Progress of a homing."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


class DriveHoming:
    """Homing of one drive; the statusword of a drive that was homed before says so until the new homing begins."""

    def __init__(self, axis: CanopenAxis, rate: float) -> None:
        """`rate`: answers per second [Hz]."""
        self._axis = axis
        self._answers_to_wait = max(2, round(_START_TIME * rate))
        self._answers = 0
        self._begun = False

    def prepare(self, settings: Homing) -> None:
        """Write method, speeds and mode, without power.

        Raises:
            BadInput: the drive has no homing mode, or does not say the unit of a speed.
            RunFailed: the drive refuses a value.
        """
        axis = self._axis
        modes = axis.dictionary.value((0x6502, 0))
        if modes and not modes >> MODE - 1 & 1:
            raise BadInput(f"{axis.name}: 6502h = 0x{modes:X}: no mode 6 (homing); home it with its own tool")
        for write in homing_writes(settings, axis.dictionary, axis.name):
            axis.sdo.write(write)
        self._set_mode(MODE)
        axis.homing = True

    def start(self) -> None:
        """Let the next controlwords of the enabled drive start the search."""
        self._axis.homing_started = True

    def finish(self) -> None:
        """Return to the mode of the rig, without power."""
        self._axis.homing = self._axis.homing_started = False
        self._set_mode(MODES[self._axis.drive.mode])

    def _set_mode(self, mode: int) -> None:
        self._axis.sdo.write(SdoWrite(0x6060, 0, "<b", mode))
        self._axis.confirm_mode(mode)

    def state(self) -> HomingState:
        """What the last statusword says; call once per `exchange`."""
        if not self._axis.answered:
            return HomingState.RUNNING
        self._answers += 1
        word = self._axis.statusword
        if word & _ERROR:
            return HomingState.FAILED
        attained = bool(word & _ATTAINED and word & _AT_REST)
        self._begun = self._begun or not attained
        believed = self._begun or self._answers > self._answers_to_wait
        return HomingState.DONE if attained and believed else HomingState.RUNNING


def homing_writes(settings: Homing, dictionary: DriveDictionary, name: str) -> list[SdoWrite]:
    """The SDO downloads of one homing; speeds and acceleration that the rig file leaves out stay as they are.

    Raises:
        BadInput: a speed or an acceleration is given, and its unit is not known.
    """
    units = dictionary.units
    values: list[tuple[int, int, float | None, Scale | None, str]] = [
        (0x6099, 1, settings.speed, units.velocity, "60A9h"),
        (0x6099, 2, settings.zero_speed, units.velocity, "60A9h"),
        (0x609A, 0, settings.acceleration, units.acceleration, "60AAh"),
    ]
    writes = [SdoWrite(0x6098, 0, "<b", settings.method)]
    for index, sub, value, scale, code in values:
        if value is None:
            continue
        if scale is None:
            raise BadInput(
                f"{name}: the drive does not say its unit ({code}), so {index:04X}:{sub:02X} cannot be written; set "
                "it in the drive, and leave speed, zero_speed and acceleration out of homing"
            )
        writes.append(SdoWrite(index, sub, "<I", max(1, round(value * scale.per_radian))))
    return writes

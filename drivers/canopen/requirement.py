"""One row of the table of what a run needs of a drive."""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from drivers.eds import Address
from recordings.drives import Drive

if TYPE_CHECKING:
    from drivers.canopen.dictionary import DriveDictionary
    from recordings.rig import Rig

Role = Literal["motion", "safety", "convenience"]
Wanted = Callable[["Rig", "DriveDictionary"], int | None]
"""Value that the run writes; None: none."""


@dataclass(frozen=True)
class Requirement:
    """What a run needs of one object."""

    address: Address
    layout: str
    """Struct format of its type by the standard."""
    role: Role
    meaning: str
    use: str = ""
    """How the run reaches it: r reads it, w writes it, m maps it into a PDO."""
    wanted: Wanted = lambda rig, dictionary: None
    needed: Callable[["DriveDictionary"], bool] = lambda dictionary: True
    """Whether a drive must have it."""
    quantity: str = ""
    """What it holds, of `_QUANTITIES`; "": what no name contradicts."""
    likewise: tuple[Address, ...] = ()
    """Objects that hold nearly the same, and which are named where it is missing."""
    opposite: str = ""
    """Pattern of words that a name has which means the other end of a range."""
    words: str = ""
    """Pattern of names that a manufacturer's object of this kind has."""
    loss: str = ""
    """For safety: what no longer protects."""
    instead: str = ""
    """For safety: what the host supervises instead; for motion: what the user may do."""
    key: str = ""
    """Key of [[drives]] that sets its value."""

    @property
    def sizes(self) -> set[int]:
        """Lengths that it may have in a PDO [bytes]."""
        return _SIZES.get(self.quantity, set()) | {struct.calcsize(self.layout)}

    def may_be_count(self, data: bytes | None) -> bool:
        """Whether its content is shorter than the standard says: in place of a value, an array has a count."""
        return data is not None and len(data) == 1 < struct.calcsize(self.layout)

    @property
    def choices(self) -> tuple[int, ...]:
        """What its key in the rig file may be, where that is one of a few numbers."""
        values = get_args(Drive.model_fields[self.key].annotation) if self.key else ()
        return tuple(value for value in values if isinstance(value, int))

    @property
    def waiver(self) -> str:
        """What is lost without it, and how the rig file accepts that."""
        return f'{self.loss}; accept_missing = ["{self.address[0]:04X}"] drives without it ({self.instead})'

    def contradicts(self, name: str) -> bool:
        """Whether a dictionary names the object as something else: a warning does not protect, and a name that says
        other quantities and not its own is of another one."""
        name = _WORD_ENDS.sub(" ", name)
        if self.role == "safety" and self.quantity and _WARNING.search(name):
            return True
        if self.opposite and re.search(rf"\b({self.opposite})\b", name, re.IGNORECASE):
            return True
        said = {quantity for quantity, words in _QUANTITIES.items() if words.search(name)}
        if self.quantity not in ("torque", "current"):
            said.discard("current")  # as in "current position"
        return bool(self.quantity and said) and self.quantity not in said

    def resembles(self, name: str) -> bool:
        """Whether a manufacturer's object of this name may hold what this one should."""
        return bool(self.words and re.search(self.words, name, re.IGNORECASE)) and not self.contradicts(name)


_SIZES = {"torque": {4}, "current": {4}, "voltage": {1, 4}}
"""Further lengths of what a PDO may hold in more than one [bytes]."""
_WORD_ENDS = re.compile(r"_|(?<=[a-z])(?=[A-Z])")
"""As in following_error_window and FollowingErrorWindow."""
_WARNING = re.compile("warn", re.IGNORECASE)
_QUANTITIES = {
    quantity: re.compile(words, re.IGNORECASE)
    for quantity, words in {
        "position": "position|angle|following|tracking|deviation|distance",
        "velocity": "velocity|speed",
        "acceleration": "deceleration|acceleration|ramp",
        "torque": "torque|force",
        "current": r"\bcurrent",
        "voltage": "voltage",
        "time": r"\btime|timeout|duration|delay|period|\bms\b",
    }.items()
}

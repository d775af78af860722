"""The mark of every simulated drive, and its own object dictionary."""

from pathlib import Path
from random import SystemRandom

from canopen.objectdictionary import datatypes

from drivers.eds import Dictionary, ObjectDescription
from drivers.protocol import SIMULATED

EDS = Path(__file__).with_name("drive.eds")
"""Dictionary of the simulated drive of this project."""
_MARK = 0x5FFF


def marked(dictionary: Dictionary, *, lockstep: bool) -> Dictionary:
    """`dictionary` with the one object that every simulated drive has, so that no recording of it passes for one of
    a real drive: 5FFFh, with the pace in sub-index 1, the number of this start in 2 (in lockstep 0, as the same seed
    gives the same frames) and a text in 3."""
    started = 0 if lockstep else SystemRandom().randrange(1, 2**32)
    mark = {
        (_MARK, 1): ObjectDescription(datatypes.UNSIGNED8, "ro", bytes([lockstep])),
        (_MARK, 2): ObjectDescription(datatypes.UNSIGNED32, "ro", started.to_bytes(4, "little")),
        (_MARK, 3): ObjectDescription(datatypes.VISIBLE_STRING, "ro", SIMULATED.encode()),
    }
    return Dictionary({**dictionary.entries, **mark}, dictionary.name, dictionary.indices | {_MARK})

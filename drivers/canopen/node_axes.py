"""Several axes on one node: where the objects of each stand (CiA 301: logical devices; CiA 402: 6800h of axis 2).

Everything else names the objects as those of the first axis; they are moved where they go on the bus, or come from a
file.
"""

from dataclasses import replace

from drivers.eds import Dictionary

_PROFILE, _PER_AXIS = 0x6000, 0x800
_PROFILES = range(_PROFILE, 0xA000)
FURTHER_AXES = range(0x6840, 0xA000, _PER_AXIS)
"""Controlwords of axes 2 ... n: a node without them is one axis, to which its further PDOs and objects belong."""
PDOS_PER_AXIS = 64
AXES = 4
"""As many axes of a node have COB-IDs for a PDO each way."""
_PDOS, _PDO_AREA = range(0x1400, 0x1C00), 0x200
"""Parameters and mappings, each kind in an area of its own."""


def axis_of(index: int) -> int | None:
    """Axis (1 ... n) to which an object belongs; None: to the node."""
    if index in _PROFILES:
        return (index - _PROFILE) // _PER_AXIS + 1
    return index % _PDO_AREA // PDOS_PER_AXIS + 1 if index in _PDOS else None


def on_node(index: int, axis: int) -> int:
    """Index on the node of an object that the first axis has at `index`; what no first axis has stays."""
    return _moved(index, axis - 1) if axis_of(index) == 1 else index


def _moved(index: int, axes: int) -> int:
    return index + axes * (_PER_AXIS if index in _PROFILES else PDOS_PER_AXIS)


def of_axis(dictionary: Dictionary, axis: int) -> Dictionary:
    """The objects of one axis, at the indices of the first one, and those of the node."""
    if axis == 1 and dictionary.indices.isdisjoint(FURTHER_AXES):
        return dictionary
    entries = {
        (index if owner is None else _moved(index, 1 - axis), sub): item
        for (index, sub), item in dictionary.items()
        if (owner := axis_of(index)) in (None, axis)
    }
    return replace(dictionary, entries=entries, indices=frozenset(index for index, _ in entries))

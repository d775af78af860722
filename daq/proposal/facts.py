"""Facts about one drive, from its EDS or DCF, or read from the drive itself."""

import re
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from drivers.canopen import check, discovery
from drivers.canopen.bus import Link, open_bus
from drivers.canopen.dictionary import DriveDictionary, read_dictionary
from drivers.canopen.node_axes import AXES, of_axis, on_node
from drivers.canopen.readiness import DRIVE_PROFILE
from drivers.canopen.requirements import ROWS
from drivers.canopen.sdo import Sdo, format_address
from drivers.eds import Address, ObjectDescription, load_dictionary
from drivers.protocol import unheard
from recordings.buses import CanBus
from recordings.errors import BadInput, RunFailed
from recordings.rig import Drive

_MAKERS = range(0x2000, 0x6000)
_NAMED_AXIS = re.compile(r"\baxis[ _-]?([1-4])\b", re.IGNORECASE)


@dataclass(frozen=True)
class DriveFacts:
    """What is known of one drive."""

    node_id: int
    name: str
    origin: str
    """File, or node on the bus."""
    data: Mapping[Address, bytes | None]
    """Value of each object that exists; zeros, or None, where the value is not known."""
    descriptions: Mapping[Address, ObjectDescription] = field(default_factory=dict)
    """Types, limits and names of the objects; empty where the drive itself was read."""
    values: str = "as read from the drive"
    """Where the values come from."""
    file: str = ""
    """The DCF with its values."""
    bit_rates: frozenset[int] = frozenset()
    """Bit rates that the file allows [bit/s]; empty: not said."""
    eds: str = ""
    """The EDS, or the DCF, with its limits."""
    axis: int = 1
    """Of the node."""

    def __contains__(self, address: Address) -> bool:
        return address in self.data

    def value(self, index: int, sub: int = 0) -> int | None:
        """Value of an integer object; None where there is no such object, or the file gives no value."""
        address = (index, sub)
        if self.descriptions and (address not in self.data or self.descriptions[address].value is None):
            return None
        return self.dictionary().value(address)

    def lack(self, address: Address) -> str:
        """See `DriveDictionary.lack`, with the object's name."""
        row = ROWS[address]
        lack = self.dictionary().lack(row)
        return f"{format_address(*address)} {row.meaning}: {lack}" if lack else ""

    def dictionary(self, drive: Drive | None = None) -> DriveDictionary:
        """The same as the driver has it; without a `drive`: whatever the rig file says."""
        return DriveDictionary(drive or Drive(node_id=self.node_id, axis=self.axis), self.data, self.descriptions)


def from_file(path: Path, node_id: int, axis: int = 1) -> DriveFacts:
    """Facts from an EDS or DCF about one axis of a node.

    Raises:
        BadInput: the file cannot be read, or describes no CiA 402 drive with this axis.
    """
    dictionary = of_axis(load_dictionary(path, node_id), axis)
    if (0x6040, 0) not in dictionary or (0x6041, 0) not in dictionary:
        words = f"controlword ({on_node(0x6040, axis):04X}h) and statusword ({on_node(0x6041, axis):04X}h)"
        what = "a CiA 402 drive" if axis == 1 else f"axis {axis} of a CiA 402 drive"
        item = dictionary.get((0x1000, 0))
        profile = item.decode(item.value) & 0xFFFF if item is not None and item.value else DRIVE_PROFILE
        says = "" if profile == DRIVE_PROFILE else f"; it says device profile {profile}"
        raise BadInput(f"{path}: {what} expected, no {words} found{says}")
    items = {address: item for address, item in dictionary.items() if _may_be_of(axis, address[0], item.name)}
    data = {a: (item.value or bytes(item.size or 0)) if item.is_readable else None for a, item in items.items()}
    kind = "values of this DCF" if dictionary.has_parameters else "defaults of this EDS, not settings of your drive"
    return DriveFacts(
        node_id,
        dictionary.name,
        path.name,
        data,
        items,
        kind,
        str(path) if dictionary.has_parameters else "",
        dictionary.bit_rates,
        str(path),
        axis,
    )


def _may_be_of(axis: int, index: int, name: str) -> bool:
    """Whether an object may belong to this axis. A manufacturer-specific one belongs to the axis in its name, such as
    "STO, axis 2", and to the first where its name says none."""
    said = _NAMED_AXIS.search(name)
    return index not in _MAKERS or axis == (int(said[1]) if said else 1)


def from_bus(bus: CanBus) -> list[DriveFacts]:
    """Facts about all CiA 402 drives on a bus and their axes, by node id; nothing is written, nothing moves.

    Raises:
        BadInput: the bus cannot be opened.
        RunFailed: another master is on the bus, no drive answers, or one stops answering.
    """
    others = list[str]()
    with closing(Link(open_bus(bus))) as link:
        discovery.check_no_other_master(link)
        found = list(_scan(link, others))
    if not found:
        answers = f" (what answers is {', '.join(others)})" if others else ""
        raise RunFailed(
            f"no CiA 402 drive answers{answers}; check power, cable, termination and bit rate; a "
            "drive that has no node id yet gets one by daq rig lss"
        )
    return found


def _scan(link: Link, others: list[str]) -> Iterator[DriveFacts]:
    """The drives; `others` gets what else answers."""
    for node in sorted(check.scan_nodes(link)):
        sdo = Sdo(node, f"node {node}", link, unheard)
        device_type = sdo.read_optional(0x1000, 0, "<I")
        if device_type is None or device_type & 0xFFFF != DRIVE_PROFILE:
            profile = "no device type" if device_type is None else f"device profile {device_type & 0xFFFF}"
            others.append(f"node {node}: {profile}")
            continue
        name = sdo.read_text(0x1008) or "a device without a name"
        for axis in range(1, AXES + 1):
            drive = Drive(node_id=node, axis=axis)
            sdo = Sdo(node, drive.address, link, unheard, axis)
            if axis > 1 and not sdo.has(0x6041, 0):
                break
            yield DriveFacts(node, name, drive.address, dict(read_dictionary(drive, sdo).data), axis=axis)

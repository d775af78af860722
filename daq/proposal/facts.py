"""Facts about one drive, from its EDS or DCF, or read from the drive itself."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from drivers.canopen import check, discovery
from drivers.canopen.bus import Link, open_bus
from drivers.canopen.dictionary import STANDARD, DriveDictionary, read_dictionary
from drivers.canopen.sdo import Sdo
from drivers.canopen.units import OBJECTS
from drivers.eds import Address, ObjectDescription, load_dictionary
from drivers.protocol import unheard
from recordings.buses import CanBus
from recordings.errors import BadInput
from recordings.rig import Drive

_CIA_402 = 402
_FURTHER: Mapping[Address, str] = {(0x6080, 0): "<I", (0x607F, 0): "<I", (0x1000, 0): "<I"}
_LAYOUTS = {**STANDARD, **OBJECTS, **_FURTHER}


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

    def __contains__(self, address: Address) -> bool:
        return address in self.data

    def value(self, index: int, sub: int = 0) -> int | None:
        """Value of an integer object; None where there is no such object, or the file gives no value."""
        address = (index, sub)
        if self.descriptions and (address not in self.data or self.descriptions[address].value is None):
            return None
        return self.dictionary(Drive(node_id=self.node_id)).value(address, _LAYOUTS.get(address))

    def can_map(self, *addresses: Address) -> bool:
        """Whether objects exist and can be mapped into a PDO, as far as this is known."""
        return all(
            address in self.data and (not self.descriptions or self.descriptions[address].mappable)
            for address in addresses
        )

    def limits(self, index: int, sub: int = 0) -> tuple[int | None, int | None]:
        """Lowest and highest value that an object accepts; None: not said."""
        description = self.descriptions.get((index, sub))
        return (None, None) if description is None else (description.low, description.high)

    def accepts(self, index: int, sub: int, value: int) -> bool:
        """Whether an object's limits include a value, as far as they are known."""
        low, high = self.limits(index, sub)
        return (low is None or value >= low) and (high is None or value <= high)

    def dictionary(self, drive: Drive) -> DriveDictionary:
        """The same as the driver has it."""
        return DriveDictionary(drive, self.data)


def from_file(path: Path, node_id: int) -> DriveFacts:
    """Facts from an EDS or DCF.

    Raises:
        BadInput: the file cannot be read, or describes no CiA 402 drive.
    """
    dictionary = load_dictionary(path, node_id)
    if (0x6040, 0) not in dictionary or (0x6041, 0) not in dictionary:
        raise BadInput(f"{path}: a CiA 402 drive expected, no controlword (6040h) and statusword (6041h) found")
    data = {address: item.value if item.value else bytes(item.size or 0) for address, item in dictionary.items()}
    kind = "values of this DCF" if dictionary.has_parameters else "defaults of this EDS, not settings of your drive"
    return DriveFacts(
        node_id,
        dictionary.name,
        path.name,
        data,
        dictionary,
        kind,
        str(path) if dictionary.has_parameters else "",
        dictionary.bit_rates,
        str(path),
    )


def from_bus(bus: CanBus) -> list[DriveFacts]:
    """Facts about all CiA 402 drives on a bus, in the order of their node ids; nothing is written, nothing moves.

    Raises:
        BadInput: the bus cannot be opened.
        RunFailed: another master is on the bus, no drive answers, or one stops answering.
    """
    link = Link(open_bus(bus))
    try:
        discovery.check_no_other_master(link)
        return list(_scan(link))
    finally:
        link.close()


def _scan(link: Link) -> Iterator[DriveFacts]:
    for node in sorted(check.scan_nodes(link)):
        sdo = Sdo(node, f"node {node}", link, unheard)
        device_type = sdo.read_optional(0x1000, 0, "<I")
        if device_type is None or device_type & 0xFFFF != _CIA_402:
            continue
        data = dict(read_dictionary(Drive(node_id=node), sdo).data)
        name = sdo.read_text(0x1008) or "a device without a name"
        yield DriveFacts(node, name, f"node {node}", data)

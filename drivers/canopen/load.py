"""Load of the CAN bus by the cycle."""

from collections.abc import Iterable, Mapping

from drivers.canopen.bus import frame_bits
from drivers.canopen.dictionary import DriveDictionary
from drivers.canopen.pdo import pdo_sizes
from recordings.rig import Rig


def bus_load(
    rig: Rig, rate: float, dictionaries: Mapping[int, DriveDictionary] | None = None, foreign: Iterable[int] = ()
) -> float:
    """Worst-case bus load (0 ... 1) of the cycle at `rate` [Hz]: SYNC, the drives' PDOs, and one SDO request with its
    response if voltages are polled.

    `dictionaries`: of the drives that are known, by node id; `foreign`: data bytes of PDOs that drives send besides,
    counted once per cycle.
    """
    known = dictionaries or {}
    sizes = [0, *foreign, *(size for drive in rig.drives for size in pdo_sizes(drive, known.get(drive.node_id)))]
    if any(drive.torque_source == "voltage" and drive.voltage.transfer == "sdo" for drive in rig.drives):
        sizes += [8, 8]
    bits = sum(frame_bits(size) for size in sizes)
    return bits * rate / rig.can.bitrate


def highest_rate(rig: Rig) -> float:
    """The rate [Hz] at which the bus load reaches the limit in the rig file."""
    return rig.can.max_load / bus_load(rig, 1.0)

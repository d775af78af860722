"""CANopen: CiA 402 drives on a CAN bus."""

from drivers.canopen import dcf, setup
from drivers.canopen.bus import Link, Tap, open_bus
from drivers.canopen.dictionary import standard_dictionary
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.kernel_sync import LEAD, KernelSync
from drivers.canopen.pdo import bus_load, highest_rate
from drivers.protocol import Amplifiers, Report
from drivers.transports import SimulatedTime
from recordings.errors import BadInput
from recordings.rig import Rig


def check(rig: Rig) -> None:
    """See `Transport`."""
    for drive in rig.drives:
        dcf.configuration(drive)
        setup.own_writes(rig, standard_dictionary(drive))
    if rig.rate > highest_rate(rig):
        raise BadInput(
            f"at {rig.rate:g} Hz the cycle would take up to {bus_load(rig, rig.rate):.0%} of the bus, bus.max_load "
            f"allows {rig.can.max_load:.0%}; choose --rate {highest_rate(rig):.3g} or less, or a higher bitrate"
        )


def describe(rig: Rig) -> str:
    """See `Transport`."""
    return (
        f"{rig.can.interface} '{rig.can.channel}', {rig.can.bitrate / 1000:g} kbit/s, at worst "
        f"{bus_load(rig, rig.rate):.0%} loaded; highest rate {highest_rate(rig):.0f} Hz"
    )


def simulated_here(rig: Rig) -> bool:
    """See `Transport`: a virtual bus exists only inside this program."""
    return rig.can.interface == "virtual"


def lead(rig: Rig) -> float:
    """See `Transport`: the kernel does not wait for targets."""
    return LEAD / rig.rate if rig.can.sync == "kernel" else 0.0


def connect(rig: Rig, report: Report, tap: Tap, clock: SimulatedTime | None) -> Amplifiers:
    """See `Transport`."""
    link = Link(open_bus(rig.can))
    link.tap, link.clock = tap, clock
    # In lockstep time is simulated, but the kernel sends SYNC in real time.
    if rig.can.sync == "host" or clock is not None:
        return CanopenDrives(rig, link, report)
    try:
        return CanopenDrives(rig, link, report, KernelSync(link, rig.can.channel, 1 / rig.rate))
    except BadInput:
        link.close()
        raise

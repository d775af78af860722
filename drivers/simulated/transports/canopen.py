"""CANopen: simulated CiA 402 drives on a CAN bus."""

from drivers.canopen.bus import Link, open_bus
from drivers.simulated.config import SimConfig
from drivers.simulated.rig import SimulatedRig
from drivers.simulated.service import Service
from recordings.errors import BadInput
from recordings.recording import Pace
from recordings.rig import Rig

_READ_DEVICE_TYPE = bytes.fromhex("4000100000000000")
"""SDO request that reads object 1000."""
_RESPONSE_TIMEOUT = 0.3
"""Time to wait for an answer [s]."""


def serve(rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
    """See `Simulation`."""
    bus = open_bus(rig.can)
    try:
        return SimulatedRig(rig, config, bus, pace=pace, seed=seed)
    except BadInput:
        bus.shutdown()
        raise


def check_not_in_use(rig: Rig) -> None:
    """See `Simulation`: reads the device type of the rig's node ids."""
    link = Link(open_bus(rig.can))
    try:
        for drive in rig.drives:
            link.send(0x600 + drive.node_id, _READ_DEVICE_TYPE)
        answers = {0x580 + drive.node_id: drive.node_id for drive in rig.drives}
        for seen, _ in link.frames(_RESPONSE_TIMEOUT):
            if seen in answers:
                raise BadInput(
                    f"node ids that are free expected on {place(rig)}, node {answers[seen]} answers; end the "
                    "other `daq sim`, or take that drive off the bus"
                )
    finally:
        link.close()


def place(rig: Rig) -> str:
    """See `Simulation`."""
    return f"{rig.can.interface} '{rig.can.channel}'"

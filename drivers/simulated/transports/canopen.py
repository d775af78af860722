"""CANopen: simulated CiA 402 drives on a CAN bus."""

from drivers.bus import open_bus
from drivers.simulated.config import SimConfig
from drivers.simulated.rig import SimulatedRig
from drivers.simulated.service import Pace, Service
from recordings.rig import Rig


def serve(rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
    """See `Simulation`."""
    return SimulatedRig(rig, config, open_bus(rig.can), pace=pace, seed=seed)


def place(rig: Rig) -> str:
    """See `Simulation`."""
    return f"{rig.can.interface} '{rig.can.channel}'"

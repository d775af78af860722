"""Serial: simulated drives with the ASCII protocol on pseudo-terminals."""

from drivers.simulated.config import SimConfig
from drivers.simulated.serial_rig import SerialRig
from drivers.simulated.service import Service
from recordings.recording import Pace
from recordings.rig import Rig


def serve(rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
    """See `Simulation`."""
    return SerialRig(rig, config, pace=pace, seed=seed)


def check_not_in_use(rig: Rig) -> None:
    """See `Simulation`: `serve` raises the error if a name is in use."""


def place(rig: Rig) -> str:
    """See `Simulation`."""
    return ", ".join(rig.serial.ports)

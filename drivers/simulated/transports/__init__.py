"""The simulated rigs, one module for each transport of `drivers.transports`, under the same name.

`Simulation` is the interface of a module.
"""

import importlib
from typing import Protocol, cast

from drivers.simulated.config import SimConfig
from drivers.simulated.service import Service
from recordings.recording import Pace
from recordings.rig import Rig


class Simulation(Protocol):
    """Interface of each module of this folder."""

    def serve(self, rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
        """Create the drives of the rig around one machine, on the rig's bus or lines; not yet running.

        Raises:
            BadInput: the bus or line cannot be opened.
        """

    def check_not_in_use(self, rig: Rig) -> None:
        """Raise BadInput if other drives already answer on the bus or lines, as far as this can be detected."""

    def place(self, rig: Rig) -> str:
        """Bus or ports of the drives, as text for the user."""


def of(rig: Rig) -> Simulation:
    """The simulation for the transport named in the rig."""
    return cast(Simulation, importlib.import_module(f"{__name__}.{rig.bus.transport}"))

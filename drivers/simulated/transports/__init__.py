"""The simulated rigs, one module for each transport of `drivers.transports`, under the same name.

What a module offers is written down in `Simulation`.
"""

import importlib
from typing import Protocol, cast

from drivers.simulated.config import SimConfig
from drivers.simulated.service import Pace, Service
from recordings.rig import Rig


class Simulation(Protocol):
    """What each module of this folder is."""

    def serve(self, rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
        """The drives of the rig around one machine, on the rig's own bus or lines; not yet running.

        Raises:
            BadInput: the bus or line cannot be opened.
        """
        ...

    def check_not_in_use(self, rig: Rig) -> None:
        """Raise BadInput where somebody answers in the place of these drives already, as far as that can be seen."""
        ...

    def place(self, rig: Rig) -> str:
        """Where they can be reached, for a person."""
        ...


def of(rig: Rig) -> Simulation:
    """The simulation for the transport that the rig names."""
    return cast(Simulation, importlib.import_module(f"{__name__}.{rig.bus.transport}"))

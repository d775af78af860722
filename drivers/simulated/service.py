"""Base of the simulated rigs: a loop that serves the drives, in its own thread or in the caller's."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence
from types import TracebackType
from typing import Literal, Protocol, Self

from drivers.simulated.machine import Machine
from drivers.simulated.setpoint_generator import SetpointGenerator

Pace = Literal["lockstep", "realtime"]

FALLING_BEHIND = 0.5
"""Real time: lag of the host above which simulated time is delayed instead of caught up [s]."""


class SimulatedDrive(Protocol):
    """The part of a simulated drive that the machine uses."""

    @property
    def powered(self) -> bool: ...

    @property
    def generator(self) -> SetpointGenerator: ...


def advance_machine(machine: Machine, drives: Sequence[SimulatedDrive], duration: float) -> bool:
    """Advance the machine by `duration` [s] with the drives' setpoints; False if less than half a plant step."""
    for j, drive in enumerate(drives):
        if machine.enabled[j] != drive.powered:
            machine.enabled[j] = drive.powered
            machine.brake[j] = not drive.powered
    steps = round(duration / machine.dt)
    if steps <= 0:
        return False
    generators = [drive.generator for drive in drives]
    machine.advance([[generator.step() for generator in generators] for _ in range(steps)])
    return True


class Service(ABC):
    """Runs in its own thread between `start` and `close`, or in the caller's with `run`."""

    def __init__(self) -> None:
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self.error: BaseException | None = None
        """Error that ended the thread."""

    @abstractmethod
    def run(self) -> None:
        """Serve until `stop` is called.

        Raises:
            RunFailed: the bus is lost.
        """

    @abstractmethod
    def leave(self) -> None:
        """Leave the bus, after the loop has ended."""

    def start(self) -> None:
        """Start the thread."""
        self._thread = threading.Thread(target=self._run_guarded, name="simulated rig", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Make `run` return."""
        self._stopping.set()

    def close(self) -> None:
        """Stop the thread and leave the bus."""
        self.stop()
        if self._thread is not None:
            self._thread.join()
        self.leave()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _run_guarded(self) -> None:
        try:
            self.run()
        except BaseException as error:
            self.error = error

"""What simulated rigs have in common: a loop that serves the drives, in a thread of its own or in the caller's."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence
from types import TracebackType
from typing import Literal, Protocol, Self

from drivers.simulated.machine import Machine
from drivers.simulated.setpoint_generator import SetpointGenerator

Pace = Literal["lockstep", "realtime"]

FALLING_BEHIND = 0.5
"""Real time: if the host cannot follow, simulated time slips rather than piling up [s]."""


class SimulatedDrive(Protocol):
    """What the machine needs of a drive."""

    @property
    def powered(self) -> bool: ...

    @property
    def generator(self) -> SetpointGenerator: ...


def advance_machine(machine: Machine, drives: Sequence[SimulatedDrive], duration: float) -> bool:
    """Let time pass [s] as the drives have it; False where it is less than half a step of the plant."""
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
    """Runs in a thread of its own between `start` and `close`, or in the caller's with `run`."""

    def __init__(self) -> None:
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self.error: BaseException | None = None
        """What ended the thread before its time."""

    @abstractmethod
    def run(self) -> None:
        """Serve until `stop` is called.

        Raises:
            RunFailed: the bus is lost.
        """

    @abstractmethod
    def leave(self) -> None:
        """Leave the bus; the loop has ended."""

    def start(self) -> None:
        """Serve from a thread."""
        self._thread = threading.Thread(target=self._run_guarded, name="simulated rig", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Let `run` return."""
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

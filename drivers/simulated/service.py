"""Base of the simulated rigs: a loop that serves the drives, in its own thread or in the caller's."""

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Protocol, Self

import numpy as np

from drivers.simulated.config import SimConfig
from drivers.simulated.machine import SimulatedMachine
from drivers.simulated.setpoint_generator import SetpointGenerator
from recordings.recording import Pace
from recordings.rig import Rig

LARGEST_LAG = 0.5
"""Real time: lag of the machine above which simulated time is delayed instead of caught up [s]."""
CHUNK = 0.001
"""Real time: longest interval between two advances of the machine [s], so that the drives answer quickly."""


class SimulatedDrive(Protocol):
    """The part of a simulated drive that the machine uses."""

    @property
    def powered(self) -> bool:
        """Whether the motor has power."""

    @property
    def generator(self) -> SetpointGenerator:
        """What computes the set-points between two cycles."""

    @property
    def torque_offset(self) -> float:
        """[N m], as commanded."""


def advance_machine(machine: SimulatedMachine, drives: Sequence[SimulatedDrive], duration: float) -> bool:
    """Advance the machine by `duration` [s] with the drives' setpoints; False if less than half a plant step."""
    for j, drive in enumerate(drives):
        if machine.enabled[j] != drive.powered:
            machine.enabled[j] = drive.powered
            machine.brake[j] = not drive.powered
    steps = round(duration / machine.dt)
    if steps <= 0:
        return False
    machine.set_torque_offsets([drive.torque_offset for drive in drives])
    generators = [drive.generator for drive in drives]
    machine.advance([[generator.step() for generator in generators] for _ in range(steps)])
    return True


class Service(ABC):
    """Drives around one machine; runs in its own thread between `start` and `close`, or in the caller's."""

    def __init__(self, rig: Rig, config: SimConfig, pace: Pace, seed: int) -> None:
        self.machine = SimulatedMachine(rig, config, np.random.default_rng(seed))
        self.warn: Callable[[str], None] = lambda text: None
        """Callback for warnings to the user."""
        self._period = 1.0 / rig.rate
        self._lockstep = pace == "lockstep"
        self._clock_zero = 0.0
        """Real time: time of the host's clock at simulated time zero [s]."""
        self._delayed = False
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

    def _start_clock(self) -> None:
        self._clock_zero = time.perf_counter() - self.machine.time

    def _is_delayed(self, now: float) -> bool:
        """Real time: whether the machine is too far behind the host's clock `now` [s], so that simulated time is
        delayed. The first delay is reported."""
        behind = now - self._clock_zero - self.machine.time
        if behind <= LARGEST_LAG:
            return False
        self._clock_zero += behind
        if not self._delayed:
            self._delayed = True
            self.warn(
                "the simulated machine is slower than real time, so its time is delayed; choose --pace lockstep, a "
                "lower rate or fewer effects, or close other programs"
            )
        return True

    def _run_guarded(self) -> None:
        try:
            self.run()
        except BaseException as error:
            self.error = error

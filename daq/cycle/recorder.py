"""Recorder with a thread of its own: the cycle queues the data, the thread encodes and writes them."""

import math
import queue
import threading
from collections.abc import Callable

import can
import numpy as np
from numpy.typing import NDArray

from drivers.protocol import Sample
from recordings.errors import RunFailed
from recordings.schemas import POSITION_DELAY, TORQUE_OFFSET, VOLTAGE_DELAY, Level
from recordings.writer import RecordingWriter

_Write = Callable[[], None]
_DECIMALS = 9
"""Decimals of the references [m, rad], so that files do not depend on the rounding of the processor."""


def _delays(stamp_ns: int, sample: Sample) -> dict[str, float]:
    """Delay of each measurement after the SYNC instant [s], by name."""
    delays = {}
    for name, values, stamps in (
        (POSITION_DELAY, sample.position, sample.position_stamp),
        (VOLTAGE_DELAY, sample.voltage, sample.voltage_stamp),
    ):
        for i, (value, stamp) in enumerate(zip(values, stamps or (), strict=bool(stamps)), start=1):
            delays[f"{name}_{i}"] = math.nan if math.isnan(value) else (stamp - stamp_ns) / 1e9
    return delays


class Recorder:
    """Queue of records, written in the order of the calls; `error` is set when writing has failed."""

    def __init__(self, writer: RecordingWriter) -> None:
        self._writer = writer
        self._queue: queue.SimpleQueue[_Write | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run_thread, name="recorder", daemon=True)
        self._thread.start()
        self.error: RunFailed | None = None
        self.frames_sent = 0
        self.frames_received = 0

    def frame(self, log_ns: int, message: can.Message, sent: bool) -> None:
        """Record one CAN frame with its time [ns]."""
        if sent:
            self.frames_sent += 1
        else:
            self.frames_received += 1
        self._queue.put(
            lambda: self._writer.can(
                log_ns,
                log_ns,
                message.arbitration_id,
                bytes(message.data),
                sent=sent,
                rtr=message.is_remote_frame,
                extended=message.is_extended_id,
                error=message.is_error_frame,
            )
        )

    def cycle(
        self,
        stamp_ns: int,
        log_ns: int,
        index: int,
        repeat: int,
        lateness: float,
        command: NDArray[np.float64],
        platform: NDArray[np.float64] | None,
        sample: Sample,
        torque_offset: NDArray[np.float64] | None = None,
    ) -> None:
        """Record one SYNC: the reference sent [rad], the platform reference [m] if there is one, the answers, and the
        torque offset sent [N m] in a run with feed-forward."""

        def write() -> None:
            writer = self._writer
            writer.joint_commands(stamp_ns, log_ns, command.round(_DECIMALS))
            if platform is not None:
                writer.platform_reference(stamp_ns, log_ns, platform.round(_DECIMALS))
            writer.joint_states(stamp_ns, log_ns, sample.position, effort=sample.effort)
            writer.amplifiers(
                stamp_ns,
                log_ns,
                index,
                repeat,
                lateness,
                sample.voltage,
                sample.statusword,
                sample.error_code,
                sample.voltage_stamp,
            )
            extra = {} if sample.position_stamp is None else _delays(stamp_ns, sample)
            if torque_offset is not None:
                extra |= {f"{TORQUE_OFFSET}_{i}": value for i, value in enumerate(torque_offset.round(_DECIMALS), 1)}
            if extra:
                writer.extra(stamp_ns, log_ns, extra)

        self._queue.put(write)

    def event(self, log_ns: int, level: Level, source: str, message: str) -> None:
        """Record one line of the log."""
        self._queue.put(lambda: self._writer.event(log_ns, level, source, message))

    def close(self, exit_status: int, reason: str) -> None:
        """Write the queued records and close the file.

        Raises:
            RunFailed: a record could not be written.
        """
        self._queue.put(lambda: self._writer.close(exit_status, reason))
        self._queue.put(None)
        self._thread.join()
        if self.error is not None:
            raise self.error

    def _run_thread(self) -> None:
        while (write := self._queue.get()) is not None:
            if self.error is None:
                try:
                    write()
                except RunFailed as error:
                    self.error = error
                except Exception as error:  # the run must not go on without its recording
                    self.error = RunFailed(f"a record cannot be written: {error!r}")


class NullRecorder:
    """Recorder that discards everything, for a dry run."""

    error: RunFailed | None = None

    def cycle(self, *row: object) -> None:
        """See `Recorder`."""

    def event(self, *line: object) -> None:
        """See `Recorder`."""

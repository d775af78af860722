"""Passive recording of a bus that another master controls; nothing is sent.

While listening, only frames are written, as they arrive, so that memory does not grow and no frame is lost if the
program is killed. A second pass reconstructs the samples at the end: the time stamps come from a line through all
SYNC arrivals. If the program is killed before that pass, `daq recover` performs it.
"""

import math
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path

import can

from daq.cycle.stopping import StopRequest
from daq.passive.reconstruct import Motion, Reconstructed, reconstruct
from daq.simulation import torque_age
from drivers.canopen import emcy
from drivers.canopen.bus import Link, open_bus
from drivers.canopen.requirements import SYNC_ID
from recordings.buses import SerialBus
from recordings.errors import BadInput, RunFailed
from recordings.files import replacement
from recordings.metadata import software
from recordings.recording import Run
from recordings.recovery import rewrite
from recordings.rig import Rig
from recordings.schemas import Level
from recordings.writer import RecordingWriter

TRAJECTORY_NAME = "listened"
"""Trajectory name of the run where the trajectory is unknown."""
SYNC_TIMEOUT = 5.0
"""Listening ends when no SYNC has come for this long after the first one [s]."""
_POLL_INTERVAL = 0.1
"""Longest time between two checks of the end conditions [s]."""


class FrameRecorder:
    """Recording of the frames of a bus, and of the emergency messages among them as events."""

    def __init__(self, out: Path, rig: Rig, run: Run) -> None:
        """Raise BadInput if `out` exists or cannot be created."""
        self.frames = self.syncs = 0
        """Received so far."""
        self.writer = RecordingWriter(out, rig, run)
        self._emcy = {0x80 + drive.node_id: (i + 1, drive.emcy) for i, drive in enumerate(rig.drives)}

    def add(self, stamp_ns: int, message: can.Message) -> bool:
        """Record a frame that another one sent; return whether it is a SYNC."""
        self.frames += 1
        arbitration_id, data = message.arbitration_id, bytes(message.data)
        self.writer.can(
            stamp_ns,
            stamp_ns,
            arbitration_id,
            data,
            sent=False,
            rtr=message.is_remote_frame,
            extended=message.is_extended_id,
            error=message.is_error_frame,
        )
        if message.is_extended_id or message.is_error_frame:
            return False
        if arbitration_id in self._emcy:
            joint, texts = self._emcy[arbitration_id]
            emergency = emcy.decode(data)
            code = emergency.code
            text = texts.get(f"{code:04X}", emergency.text) + emergency.details
            level: Level = "error" if emergency.ends_run else "warning" if code else "info"
            self.writer.event(stamp_ns, level, f"joint {joint}", f"EMCY 0x{code:04X}: {text}")
        self.syncs += arbitration_id == SYNC_ID
        return arbitration_id == SYNC_ID


class Listener(FrameRecorder):
    """Recorder of all frames on `bus` in the new recording `out`."""

    def __init__(self, bus: can.BusABC, rig: Rig, out: Path) -> None:
        """Raise BadInput if `out` exists or cannot be created."""
        super().__init__(out, rig, listened_run(rig))
        self._link = Link(bus)
        self._link.tap = self._on_frame
        self._last_sync = math.inf

    def listen(
        self, stop: StopRequest, duration: float, show: Callable[[FrameRecorder], None] = lambda recorder: None
    ) -> str:
        """Listen until a stop request, for `duration` [s], or until SYNC has ceased; return the reason for the end.

        Raises:
            RunFailed: the bus is lost, or the file cannot be written.
        """
        with self.writer as writer:
            end = time.monotonic() + duration
            while (reason := self._end_reason(stop, end)) is None:
                self._link.receive(_POLL_INTERVAL)
                show(self)
            writer.close(0, reason)
        return reason

    def _end_reason(self, stop: StopRequest, end: float) -> str | None:
        if stop.count:
            return stop.reason
        if time.monotonic() >= end:
            return "the time to listen was over"
        # After a stall of this program, the frames that arrived meanwhile are still to be read.
        while self._is_sync_overdue() and self._link.receive(0.0) is not None:
            pass
        return f"no SYNC for {SYNC_TIMEOUT:g} s" if self._is_sync_overdue() else None

    def _is_sync_overdue(self) -> bool:
        return time.monotonic() - self._last_sync > SYNC_TIMEOUT

    def _on_frame(self, stamp_ns: int, message: can.Message, sent: bool) -> None:
        if self.add(stamp_ns, message):
            self._last_sync = time.monotonic()


def check(rig: Rig) -> None:
    """Raise BadInput if the bus of `rig` cannot be listened to."""
    if isinstance(rig.bus, SerialBus):
        raise BadInput("a CAN bus expected: on a serial line nobody but its master hears the drives; found serial")
    if rig.bus.interface == "virtual":
        raise BadInput("the virtual bus ends at this program; set bus.interface to socketcan or udp_multicast")


def record(
    rig: Rig,
    out: Path,
    motion: Motion | None,
    duration: float | None,
    show: Callable[[FrameRecorder], None],
    *,
    lockstep: bool = False,
) -> tuple[FrameRecorder, Reconstructed]:
    """Listen on the bus of `rig` and write the new recording `out`; see `Listener.listen` for when it ends.

    lockstep: as in `reconstruct`.

    Raises:
        BadInput: the bus cannot be opened, or `out` cannot be created.
        RunFailed: the bus is lost, no SYNC was heard, or the file cannot be written.
    """
    with open_bus(rig.can) as bus, StopRequest() as stop:
        listener = Listener(bus, rig, out)
        reason = listener.listen(stop, math.inf if duration is None else duration, show)
        # Within the StopRequest, so that a signal cannot interrupt the reconstruction of the samples.
        return listener, complete(out, rig, motion, {"exit_status": "0", "reason": reason}, lockstep=lockstep)


def listened_run(rig: Rig) -> Run:
    """The run of a recording that begins now, of which only the rig is known."""
    return Run(
        trajectory=TRAJECTORY_NAME,
        trajectory_digest="",
        period=0.0,
        cycles=1,
        rate=rig.rate,
        software=software(),
        simulated=False,
        pace="realtime",
        start=datetime.fromtimestamp(time.time(), UTC).isoformat(timespec="milliseconds"),
    )


def complete(
    path: Path, rig: Rig, motion: Motion | None, end: Mapping[str, str], *, lockstep: bool = False
) -> Reconstructed:
    """Add the samples to the recording `path`, which holds frames only; `end` is added to its last record `run`.

    Raises:
        RunFailed: there is no SYNC among the frames; the recording is unchanged.
        OSError: the new file cannot be written; the recording is unchanged.
    """
    reconstructed = reconstruct(path, rig, motion, lockstep=lockstep)
    if reconstructed is None:
        raise RunFailed(
            f"no SYNC was heard, so {path} holds frames but no samples; check the bus, its bit rate, and that a "
            "master is at work"
        )
    with replacement(path) as partial:
        rewrite(path, partial, {**_run_entries(reconstructed, rig), **end}, reconstructed.samples)
    return reconstructed


def _run_entries(reconstructed: Reconstructed, rig: Rig) -> dict[str, str]:
    """Entries of the record `run` that follow from the frames."""
    run = {
        "rate": reconstructed.rate,
        "period": reconstructed.period,
        "cycles": reconstructed.cycles,
        "simulated": reconstructed.simulated,
    }
    if reconstructed.simulated:
        run["torque_age"] = torque_age(rig.rate)
    texts = {name: str(value).lower() for name, value in run.items()}
    if reconstructed.trajectory is not None:
        texts |= {"trajectory": reconstructed.trajectory.name, "trajectory_digest": reconstructed.trajectory.digest}
    return texts

"""Session of one recording: discover and configure the drives, open the file, stream, close everything."""

import errno
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import can

from daq.cycle.clock import Clock, HostClock, LockstepClock
from daq.cycle.exchange import RunParts
from daq.cycle.pose_memory import PoseMemory
from daq.cycle.progress import CycleProgress
from daq.cycle.realtime import realtime_priority
from daq.cycle.recorder import NullRecorder, Recorder
from daq.cycle.stopping import StopRequest
from daq.cycle.stream import Stream
from daq.feedforward.planning import Feedforward
from daq.feedforward.source import TorqueSource
from daq.simulation import torque_age
from daq.watch import RunWatch, WatchProcess
from drivers import transports
from drivers.canopen.bus import Tap
from drivers.protocol import Amplifiers, Identity, Report, unheard
from recordings.errors import BadInput, RunFailed, StoppedByAlarm
from recordings.metadata import software
from recordings.recording import Floats, Pace, Run
from recordings.rig import Rig
from recordings.schemas import Level
from recordings.writer import RecordingWriter
from trajectories import Trajectory

Display = Callable[[CycleProgress], AbstractContextManager[object]]

_BYTES_PER_CYCLE = 400
"""Upper bound of the bytes per cycle in the file, to check the free disk space before the run."""


@dataclass(frozen=True)
class RunRequest:
    """Request to record one run."""

    rig: Rig
    trajectory: Trajectory
    out: Path
    pace: Pace
    seed: int | None
    """Seed of the noise of the simulated rig; None with real drives."""
    plan: Callable[[Floats], Trajectory] | None = None
    """Motion from the pose (dof,) [rad] in which the robot stands, planned before power; `trajectory` then only has
    its name and its length."""
    feedforward: TorqueSource | None = None
    """Torque to feed forward, if any; the rig then sends torque offsets."""
    accepted: frozenset[str] = frozenset()
    """What is accepted by name."""
    watch: RunWatch | None = None
    """The model that goes along, if any."""
    stop_at: int | None = None
    """See `RunParts`."""
    prepare: Callable[[Amplifiers], object] = unheard
    """What is done with the drives when they are found."""


@dataclass(frozen=True)
class Result:
    """Result of a run."""

    identities: tuple[Identity, ...]
    progress: CycleProgress
    frames_sent: int
    frames_received: int


def check_request(request: RunRequest) -> None:
    """Check the request before anything is opened or moves.

    Raises:
        BadInput: the file exists, its folder does not exist or cannot be written, the disk is full, or the rate does
            not suit the bus or the drives.
    """
    folder = request.out.resolve().parent
    if request.out.suffix != ".mcap":
        raise BadInput(f"a recording's name (.mcap) expected, {request.out} found; give another --out")
    if request.out.exists():
        raise BadInput(f"a new name expected, {request.out} exists and no recording is replaced; give another --out")
    if not folder.is_dir():
        raise BadInput(f"folder {folder} does not exist; create it or choose another --out")
    try:
        # A trial file is more reliable than permission bits: root may write everywhere, except in places like /proc.
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise BadInput(f"folder {folder} cannot be written: {error.strerror}; choose another --out") from None
    needed = len(request.trajectory.repeat) * _BYTES_PER_CYCLE + 100_000
    free = shutil.disk_usage(folder).free
    if free < needed:
        raise BadInput(f"disk full: {needed / 1e6:.1f} MB needed in {folder}, {free / 1e6:.1f} MB free; make room")
    transports.of(request.rig).check(request.rig)


class Session:
    """Session of one run; `log` gets the reports of the drives and the cycle (level, source, message)."""

    def __init__(self, request: RunRequest, log: Report) -> None:
        self._request = request
        self._log = log
        rig = request.rig
        # In lockstep, time is simulated.
        self._clock: Clock = (
            LockstepClock(rig.rate)
            if request.pace == "lockstep"
            else HostClock(rig.rate, transports.of(rig).lead(rig))
        )
        # Frames before the file is open: it can be opened only when the drives are identified.
        self._early_frames: list[tuple[int, can.Message, bool]] = []
        self._write_frame: Tap = lambda *frame: self._early_frames.append(frame)
        self._recorder: Recorder | None = None
        self._poses: PoseMemory | None = None
        """The memory of the poses, once they are found to be right."""
        self.progress = CycleProgress()
        source = request.feedforward
        self._feedforward = None if source is None else Feedforward(source, rig, request.accepted, self._report)

    def run(self, display: Display) -> Result:
        """Record the run; in every case the drives are disabled and the file is closed with its exit status.

        Raises:
            RunFailed: the motion was not completed, or the file was not written to its end.
            StoppedByAlarm: the watch has stopped the motion.
            BadInput: the bus or the file cannot be opened.
        """
        # Signals are caught until everything is closed, so that repeated signals cannot interrupt the closing.
        with StopRequest() as stop:
            drives = self._connect()
            status, reason = 1, "the program was interrupted"
            watch: WatchProcess | None = None
            try:
                identities = drives.discover()
                self._check_identities(identities)
                self._request.prepare(drives)
                self._recorder = self._open_recorder(identities)
                self._write_frame = self._recorder.frame
                self._tell_poses()
                watch = self._start_watch(stop)
                with display(self.progress), self._realtime_priority():
                    # Jog and axis check plan a small motion where the robot stands: it decides the unit of position.
                    drives.configure(decided=self._request.plan is None)
                    stream = self._stream(drives, self._recorder, stop)
                    try:
                        stream.run(self._request.trajectory, self._request.plan)
                    finally:  # what is missing may be why it ended early
                        self._report_loss(identities)
                status, reason = 0, "done"
            except Exception as error:
                reason = str(error)
                if watch is not None and reason == watch.reason:
                    status = StoppedByAlarm.exit_code
                    raise StoppedByAlarm(reason) from None
                raise
            finally:
                try:
                    self._keep_pose()
                    drives.close()
                finally:
                    self._close(status, reason)
                    if watch is not None:
                        watch.finish()
        return Result(identities, self.progress, self._recorder.frames_sent, self._recorder.frames_received)

    def dry_run(self, display: Display) -> tuple[Result, list[float]]:
        """Do everything of `run` except power and file; return the result and the joint positions [rad].

        Raises:
            RunFailed: a drive does not answer, reports a fault, or rejects its configuration.
            BadInput: the bus cannot be opened.
        """
        drives = self._connect()
        try:
            identities = drives.discover()
            self._check_identities(identities)
            with StopRequest() as stop, display(self.progress), self._realtime_priority():
                drives.configure()
                position = self._stream(drives, NullRecorder(), stop).dry_run(self._request.trajectory)
        finally:
            drives.close()
        sent = sum(frame[2] for frame in self._early_frames)
        return Result(identities, self.progress, sent, len(self._early_frames) - sent), position.tolist()

    def _start_watch(self, stop: StopRequest) -> WatchProcess | None:
        watch = self._request.watch
        return None if watch is None else WatchProcess(watch, self._request.out, self._report, stop.ask)

    def _stream(self, drives: Amplifiers, recorder: Recorder | NullRecorder, stop: StopRequest) -> Stream:
        rig = self._request.rig
        ahead, stop_at = self._feedforward, self._request.stop_at
        return Stream(RunParts(rig, drives, self._clock, recorder, stop, self.progress, ahead, stop_at))

    def _connect(self) -> Amplifiers:
        clock = self._clock.now if self._request.pace == "lockstep" else None
        return transports.of(self._request.rig).connect(self._request.rig, self._report, self._tap, clock)

    def _realtime_priority(self) -> AbstractContextManager[None]:
        return nullcontext() if self._request.pace == "lockstep" else realtime_priority(self._report)

    def _open_recorder(self, identities: tuple[Identity, ...]) -> Recorder:
        request = self._request
        lockstep = request.pace == "lockstep"
        is_simulated = any(identity.simulated for identity in identities)
        run = Run(
            trajectory=request.trajectory.name,
            trajectory_digest=request.trajectory.digest,
            period=request.trajectory.period,
            cycles=request.trajectory.cycles,
            rate=request.rig.rate,
            software=software(),
            simulated=is_simulated,
            pace=request.pace,
            feedforward=None if request.feedforward is None else request.feedforward.digest,
            torque_age=torque_age(request.rig.rate) if is_simulated else None,
            seed=request.seed,
            # In lockstep, time is simulated and begins at the epoch.
            start=datetime.fromtimestamp(0 if lockstep else time.time(), UTC).isoformat(timespec="milliseconds"),
        )
        recorder = Recorder(RecordingWriter(request.out, request.rig, run))
        for frame in self._early_frames:
            recorder.frame(*frame)
        for identity in identities:
            text = f"{identity.device}, vendor 0x{identity.vendor_id:X}, product 0x{identity.product_code:X}"
            text += f", firmware {identity.firmware}" if identity.firmware else ""
            text += f", serial number {identity.serial_number}" if identity.serial_number else ""
            recorder.event(self._clock.now(), "info", f"joint {identity.joint}", f"{identity.address}: {text}")
        return recorder

    def _report_loss(self, identities: tuple[Identity, ...]) -> None:
        simulated = any(identity.simulated for identity in identities)
        if loss := self.progress.loss(self._request.rig.rate, len(identities), simulated=simulated):
            self._report("warning", "cycle", loss)

    def _tell_poses(self) -> None:
        """Record by what each absolute zero is guarded, and say where it is not or was accepted."""
        # In lockstep drives have no past, and the same seed gives the same recording.
        results = self._poses.results() if self._poses is not None and self._request.pace != "lockstep" else ()
        for result in results:
            level: Level = "info" if result.verdict in ("fine", "accepted") else "warning"
            self._report(level, result.where, f"{result.what}: {result.found}")

    def _keep_pose(self) -> None:
        """Keep the last known pose."""
        if self._poses is not None and self.progress.pose:
            self._poses.keep(self.progress.pose, self._report)

    def _tap(self, time_ns: int, message: can.Message, sent: bool) -> None:
        self._write_frame(time_ns, message, sent)

    def _check_identities(self, identities: tuple[Identity, ...]) -> None:
        if self._feedforward is not None:
            self._feedforward.check_drives(identities)
        lockstep = {identity.lockstep for identity in identities}
        if self._request.pace == "lockstep" and lockstep != {True}:
            raise BadInput("--pace lockstep needs drives simulated in lockstep; real drives run in real time only")
        if self._request.pace == "realtime" and True in lockstep:
            raise BadInput("these simulated drives run in lockstep; record with --pace lockstep")
        poses = PoseMemory(self._request.rig, identities)
        poses.check(self._request.accepted)
        self._poses = poses

    def _report(self, level: Level, source: str, message: str) -> None:
        self._log(level, source, message)
        self.progress.reports.append((level, source, message))
        if self._recorder is not None:
            self._recorder.event(self._clock.now(), level, source, message)

    def _close(self, status: int, reason: str) -> None:
        if self._recorder is None:
            return
        self._recorder.event(self._clock.now(), "info" if status == 0 else "error", "daq", reason)
        try:
            self._recorder.close(status, reason)
        except RunFailed:
            # This error replaces the error of the run, so the reason of the latter is logged.
            if status != 0:
                self._log("error", "daq", reason)
            raise
        if status != 0:
            self._log("info", "daq", f"{self._request.out} is whole and holds all up to here")

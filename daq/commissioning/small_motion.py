"""Small motions of one joint from the pose in which the robot stands, run and recorded like any motion."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from daq.commissioning.hold import RELEASE, HoldToRun
from daq.cycle.progress import CycleProgress
from daq.cycle.session import RunRequest, Session, check_request
from daq.cycle.stopping import reason_of
from daq.live.status import StatusLines, to_stdout
from daq.live.terminal import ProgressBar
from daq.simulation import configured, simulated
from drivers import transports
from drivers.protocol import Report
from drivers.simulated.seal import sealed_path
from recordings.command_line import say
from recordings.errors import BadInput, RunFailed
from recordings.reader import read
from recordings.recording import Floats, Pace, Recording
from recordings.rig import Rig
from trajectories import Trajectory
from trajectories.multisine import middle_pose
from trajectories.small_moves import within_limits

Plan = Callable[[Floats], Trajectory]
"""Motion from a pose (dof,) [rad or m]."""


@dataclass(frozen=True)
class Machine:
    """The drives: those of the rig, or simulated ones."""

    rig: Rig
    pace: Pace
    sim_file: Path | None

    @classmethod
    def of(cls, rig: Rig, pace: str | None, sim_file: Path | None) -> "Machine":
        """The drives of `rig`; simulated ones run in lockstep unless `pace` says otherwise.

        Raises:
            BadInput: a sim file for real drives, or real drives in lockstep.
        """
        is_simulated = transports.of(rig).simulated_here(rig)
        if not is_simulated and sim_file:
            raise BadInput("--sim is for drives simulated inside this program; give it to `daq sim`")
        lockstep = pace == "lockstep" or (pace is None and is_simulated)
        return cls(rig, "lockstep" if lockstep else "realtime", sim_file)

    @property
    def simulated(self) -> bool:
        """Whether the drives are simulated inside this program."""
        return transports.of(self.rig).simulated_here(self.rig)

    def unit(self, joint: int) -> str:
        """Unit of the position of `joint`.

        Raises:
            BadInput: there is no such joint.
        """
        if not 1 <= joint <= self.rig.dof:
            raise BadInput(f"--joint: 1 to {self.rig.dof} expected, {joint} found")
        return self.rig.position_units[joint - 1]

    def announce(self, motion: str) -> None:
        """Say on stderr what moves."""
        if self.simulated:
            say("SIMULATED RIG: no real drive is connected.", "yellow")
        say(f"{self.rig.name}: {motion}, {self.pace}")

    @contextmanager
    def serve(self, truth: Path) -> Iterator[None]:
        """Run the simulated drives, if they are simulated; `truth`: sealed file of hidden effects."""
        if not self.simulated:
            yield
            return
        with simulated(self.rig, configured(self.rig, self.sim_file, None, truth), self.pace, 0):
            yield


@dataclass(frozen=True)
class Moved:
    """A run and its recording."""

    recording: Recording
    error: str | None
    """Why the motion was not completed; None: it was."""
    released: bool
    """Whether it ended because the keep-alives ended, and for no other reason."""

    @property
    def pose(self) -> Floats:
        """Pose (dof,) from which the motion began [rad or m]."""
        known = np.isfinite(self.recording.position).all(axis=1)
        return np.asarray(self.recording.position[np.argmax(known)])

    def ends(self, joint: int) -> tuple[float, float]:
        """First and last measured position of `joint` (1 ... n) [rad or m].

        Raises:
            RunFailed: the run ended before a drive answered.
        """
        position = self.recording.position[:, joint - 1]
        known = position[np.isfinite(position)]
        if not len(known):
            raise RunFailed(self.error or f"joint {joint} did not answer")
        return float(known[0]), float(known[-1])

    def contradiction(self, joint: int) -> str:
        """What a failed run shows about `joint` (1 ... n): "" where its position did not run against the command."""
        command, position = self.recording.command[:, joint - 1], self.recording.position[:, joint - 1]
        known = np.isfinite(command) & np.isfinite(position)
        moved = np.column_stack([command[known] - command[known][:1], position[known] - position[known][:1]])
        if not len(moved) or np.sum(moved[:, 0] * moved[:, 1]) >= 0:
            return ""
        return f"; joint {joint} runs against its command: check the direction of the encoder and the motor phases"


def move(machine: Machine, plan: Plan, out: Path | None, log: Report, *, hold: int | None, status: bool) -> Moved:
    """Run the motion that `plan` makes from the present pose, and record it to `out`, or to a file that is deleted.

    `hold`: file descriptor of the keep-alives without which the motion stops; `status`: JSON lines on stdout.

    Raises:
        BadInput: the motion exceeds a limit, or the file exists. Nothing has moved.
        RunFailed: the run ended before it was recorded.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = out or Path(folder) / "move.mcap"
        request = RunRequest(
            rig=machine.rig,
            trajectory=plan(middle_pose(machine.rig)),
            out=path,
            pace=machine.pace,
            seed=0 if machine.simulated else None,
            plan=lambda pose: within_limits(plan(pose), machine.rig),
        )
        check_request(request)
        watchers: list[HoldToRun] = []
        error = None
        with machine.serve(sealed_path(path)):
            try:
                Session(request, log if out else _without_file(log)).run(
                    lambda progress: _display(progress, machine.rig.rate, hold, status, watchers)
                )
            except BadInput:
                path.unlink(missing_ok=True)
                raise
            except RunFailed as failure:
                if not path.exists():
                    raise
                error = str(failure)
        released = error in (None, reason_of(RELEASE)) and any(watcher.released for watcher in watchers)
        return Moved(_recording(path, error), error, released)


def _recording(path: Path, error: str | None) -> Recording:
    """Read the recording of a run.

    Raises:
        RunFailed: the run failed before there was a sample.
    """
    try:
        return read(path)
    except BadInput:
        if error is None:
            raise
        raise RunFailed(error) from None


def _without_file(log: Report) -> Report:
    """`log` without what is said about the file."""
    return lambda level, source, message: None if source == "daq" else log(level, source, message)


@contextmanager
def _display(
    progress: CycleProgress, rate: float, hold: int | None, status: bool, watchers: list[HoldToRun]
) -> Iterator[None]:
    with ExitStack() as stack:
        stack.enter_context(StatusLines(progress, rate, [to_stdout]) if status else ProgressBar(progress))
        if hold is not None:
            watchers.append(stack.enter_context(HoldToRun(progress, hold)))
        yield

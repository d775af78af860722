"""Small motions of one joint from the pose in which the robot stands, run and recorded like any motion."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from daq.bench import Bench
from daq.commissioning.hold import RELEASE, HoldToRun
from daq.cycle.progress import CycleProgress
from daq.cycle.session import RunRequest, Session, check_request
from daq.cycle.stopping import reason_of
from daq.live.status import StatusLines, to_stdout
from daq.live.terminal import ProgressBar
from drivers.protocol import Amplifiers, Report, unheard
from recordings.errors import BadInput, RunFailed
from recordings.reader import read
from recordings.recording import Floats, Recording
from trajectories import Trajectory
from trajectories.multisine import middle_pose
from trajectories.small_moves import within_limits

_LARGEST_LAG = 0.2
"""Share of a commanded way that a joint at rest may be away from its end; a short way is a few counts of friction."""
Plan = Callable[[Floats], Trajectory]
"""Motion from a pose (dof,) [rad or m]."""


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

    def refuse_laggard(self, joint: int, unit: str) -> None:
        """Raise RunFailed if `joint` (1 ... n), whose position is in `unit`, did not come to where it was to go."""
        command, (start, end) = self.recording.command[:, joint - 1], self.ends(joint)
        known = command[np.isfinite(command)]
        way, moved = known[-1] - known[0], end - start
        if abs(moved - way) > _LARGEST_LAG * abs(way):
            raise RunFailed(
                f"joint {joint} does not follow: it moved by {moved:+.4f} of {way:+.4f} {unit}; look for a brake, "
                "too low a torque limit, or a wrong gear, counts_per_turn or sign of the rig file"
            )

    def contradiction(self, joint: int) -> str:
        """What a failed run shows about `joint` (1 ... n): "" where its position did not run against the command."""
        command, position = self.recording.command[:, joint - 1], self.recording.position[:, joint - 1]
        known = np.isfinite(command) & np.isfinite(position)
        moved = np.column_stack([command[known] - command[known][:1], position[known] - position[known][:1]])
        if not len(moved) or np.sum(moved[:, 0] * moved[:, 1]) >= 0:
            return ""
        return f"; joint {joint} runs against its command: check the direction of the encoder and the motor phases"


def move(
    bench: Bench,
    plan: Plan,
    out: Path | None,
    log: Report,
    *,
    hold: int | None = None,
    status: bool = False,
    stop_at: int | None = None,
    prepare: Callable[[Amplifiers], object] = unheard,
) -> Moved:
    """Run the motion that `plan` makes from the present pose, and record it to `out`, or to a file that is deleted.

    `hold`: file descriptor of the keep-alives without which the motion stops; `status`: JSON lines on stdout;
    `stop_at`: row of the motion at which it ends by a quick stop; `prepare`: see `RunRequest`.

    Raises:
        BadInput: the motion exceeds a limit, or the file exists. Nothing has moved.
        RunFailed: the run ended before it was recorded.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = out or Path(folder) / "move.mcap"
        request = RunRequest(
            rig=bench.rig,
            trajectory=plan(middle_pose(bench.rig)),
            out=path,
            pace=bench.pace,
            seed=bench.seed,
            accepted=bench.accepted,
            stop_at=stop_at,
            prepare=prepare,
            plan=lambda pose: within_limits(plan(pose), bench.rig),
        )
        check_request(request)
        watchers: list[HoldToRun] = []
        error = None
        with bench.serve(path):
            try:
                Session(request, log if out else _without_file(log)).run(
                    lambda progress: _display(progress, bench.rig.rate, hold, status, watchers)
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
        stack.enter_context(StatusLines(progress, rate, to_stdout) if status else ProgressBar(progress))
        if hold is not None:
            watchers.append(stack.enter_context(HoldToRun(progress, hold)))
        yield

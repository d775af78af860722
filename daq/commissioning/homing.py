"""Homing: one drive after the other searches its zero by itself, while the others hold; supervised like a motion."""

import math
from collections.abc import Iterator
from contextlib import closing, nullcontext
from dataclasses import dataclass, replace

from daq.cycle.clock import Clock, HostClock, LockstepClock
from daq.cycle.exchange import RunParts
from daq.cycle.pose_memory import PoseMemory
from daq.cycle.progress import CycleProgress
from daq.cycle.realtime import realtime_priority
from daq.cycle.recorder import NullRecorder
from daq.cycle.stopping import StopRequest
from daq.cycle.stream import MotionFault, Stream
from daq.cycle.supervisor import JointArray, Supervisor
from drivers import transports
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.homing import DriveHoming, HomingState
from drivers.protocol import Report, Sample, unheard
from recordings.errors import BadInput
from recordings.recording import Floats, Pace
from recordings.rig import Homing, Rig


@dataclass(frozen=True)
class Homed:
    """Outcome for one joint."""

    joint: int
    """1 ... n."""
    method: int | None
    """Object 6098; None: nothing was done."""
    position: float
    """Where the joint stands now [rad or m]; NaN where nothing was done."""
    reason: str
    """Why nothing was done; "" where it was homed."""


class HomingSupervisor(Supervisor):
    """Supervisor while one joint searches its zero: its position is not known and may jump when it finds it."""

    def __init__(self, rig: Rig, joint: int) -> None:
        """`joint`: 1 ... n."""
        super().__init__(rig)
        self._searching = joint - 1

    def standstill(self, position: JointArray) -> str | None:
        """See `Supervisor`: angles mean nothing before the zero is known."""
        return None

    def motion(self, sample: Sample, target: JointArray, torque_offset: JointArray | None = None) -> str | None:
        """See `Supervisor`: of the joint that searches, only power and torque are checked."""
        position = list(sample.position)
        position[self._searching] = math.nan
        return super().motion(replace(sample, position=tuple(position)), target, torque_offset)


class HomingStream(Stream):
    """Run of one homing on configured drives. They end disabled in every case."""

    def home(self, homing: DriveHoming, joint: int, settings: Homing, clock: Clock) -> float:
        """Home `joint` (1 ... n); returns where it stands then [rad or m].

        `clock` goes on with the next SYNC: no time counts as missed that passed since the last homing.

        Raises:
            RunFailed: it was not homed; the drives are disabled (or the message names the others).
        """
        self._supervisor, self._parts.clock = HomingSupervisor(self._parts.rig, joint), clock
        with self._supervised():
            self._wait_for_answers()
            held = self._enable()
            homing.start()
            sample = self._search(homing, joint, settings.timeout, held)
        return sample.position[joint - 1]

    def _search(self, homing: DriveHoming, joint: int, timeout: float, held: Floats) -> Sample:
        progress, count = self._parts.progress, self._parts.cycle_count(timeout)
        progress.phase, progress.total = f"home {joint}", count
        (setpoint,) = self._parts.amplifiers.encode(held[None])
        for cycle in range(count):
            if self._parts.stop.count:
                raise MotionFault(self._parts.stop.reason)
            sample = self._exchange.run(setpoint, held)
            self._raise_fault(self._supervisor.drives(sample) or self._supervisor.motion(sample, held))
            progress.done = cycle
            state = homing.state()
            if state is HomingState.FAILED:
                raise MotionFault(f"joint {joint}: homing error (statusword bit 13); check switch, method and speeds")
            if state is HomingState.DONE:
                return sample
        raise MotionFault(f"joint {joint}: not homed within {timeout:g} s; check the switch, or raise homing.timeout")


def home(rig: Rig, joints: list[int], pace: Pace, log: Report, *, again: bool) -> Iterator[Homed]:
    """Home the drives of `joints` (1 ... n) one after the other; yields each outcome.

    `again`: also drives that say that they have their zero reference.

    Raises:
        BadInput: drives on serial lines, a drive without homing mode, or simulated drives in the other pace.
        RunFailed: a drive was not homed; all are disabled.
    """
    lockstep = pace == "lockstep"
    simulated_clock = LockstepClock(rig.rate)
    connected = transports.of(rig).connect(rig, log, unheard, simulated_clock.now if lockstep else None)
    priority = nullcontext() if lockstep else realtime_priority(log)
    with StopRequest() as stop, closing(connected) as drives, priority:
        if not isinstance(drives, CanopenDrives):
            raise BadInput("drives on a CAN bus expected, serial lines found; home these drives with their own tool")
        identities = drives.discover()
        if any(identity.lockstep != lockstep for identity in identities):
            raise BadInput(
                "--pace lockstep needs drives simulated in lockstep; real drives are homed in real time only"
                if lockstep
                else "these simulated drives run in lockstep; home them with --pace lockstep"
            )
        drives.configure(referenced=False)
        poses = PoseMemory(rig, identities)
        stream = HomingStream(RunParts(rig, drives, simulated_clock, NullRecorder(), stop, CycleProgress()))
        for joint in joints:
            settings = rig.drives[joint - 1].homing
            if settings is None:
                yield Homed(joint, None, math.nan, "absolute encoder (no homing in the rig file)")
            elif drives.is_homed(joint) and not again:
                yield Homed(joint, None, math.nan, "has its zero reference already; --again homes it anew")
            else:
                homing = drives.homing(joint)
                homing.prepare(settings)
                clock = simulated_clock if lockstep else HostClock(rig.rate, transports.of(rig).lead(rig))
                position = stream.home(homing, joint, settings, clock)
                homing.finish()
                poses.keep([position if number == joint else math.nan for number in range(1, rig.dof + 1)], log)
                yield Homed(joint, settings.method, position, "")

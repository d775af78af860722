"""The motions of an axis check: swings of each joint, again with a known mass, and a quick stop from slow motion."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

from daq.bench import Bench
from daq.commissioning.axis_check import (
    AxisFigures,
    figures_of,
    share_of_payload,
    stop_deceleration,
    velocity_over_slope,
)
from daq.commissioning.small_motion import move
from daq.cycle.stream import STOPPED_TO_SEE
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.poll import PolledVelocity
from drivers.canopen.requirements import TooCoarse
from drivers.protocol import Amplifiers, Report
from recordings.command_line import say, say_report
from recordings.errors import BadInput, RunFailed
from recordings.recording import Floats
from trajectories import Trajectory
from trajectories.multisine import middle_pose
from trajectories.small_moves import jog, swing

_SPEED = 0.05
"""Speed from which the quick stop is made [rad/s or m/s]."""
_WAY = 0.3
"""Length of the motion in whose middle it is made [rad or m]: in units that are much too soft, the joint goes on for
three seconds until its power is off, and stays on this way."""
_STOP_TIME = 0.4
"""Time that the stop should take, long beside the lag of a position loop [s]."""
_STOP_ROWS = 10
"""Samples of a stop, at least, where the unit of the drive is too coarse for this time."""


@dataclass(frozen=True)
class AxisSwings:
    """Motions on one bench; `amplitude`: deviation to both sides [rad or m]."""

    bench: Bench
    amplitude: float
    log: Report = field(default_factory=lambda: cache(say_report))
    """Says what is true of every motion once."""

    def figures(self, joints: Sequence[int], travel: float | None, payload: float | None) -> list[AxisFigures]:
        """Figures of the `joints` (1 ... n); `travel`: true angle between the ends of the swing of one joint [rad];
        `payload`: a known mass [kg].

        Raises:
            RunFailed: a motion was not completed.
        """
        self.bench.announce(", ".join(map(self._motion, joints)))
        figures = []
        for joint in joints:
            seen, _ = self._swing(self.bench, joint)
            if travel is not None:
                seen = replace(seen, true_travel=travel / (2 * self.amplitude * abs(seen.travel)))
            figures.append(self._with_stop(seen))
        return figures if payload is None else [self._with_payload(seen, payload) for seen in figures]

    def _motion(self, joint: int) -> str:
        return f"joint {joint} by ±{self.amplitude:g} {self.bench.unit(joint)}"

    def _swing(self, bench: Bench, joint: int) -> tuple[AxisFigures, Trajectory]:
        say(f"swinging {self._motion(joint)}")
        plan = partial(swing, bench.rig, joint=joint, amplitude=self.amplitude)
        found: list[Amplifiers] = []
        moved = move(bench, plan, None, self.log, prepare=found.append)
        if moved.error is not None:
            raise RunFailed(f"{moved.error}{moved.contradiction(joint)}")
        motion = plan(moved.pose)
        in_doubt = any(isinstance(drives, CanopenDrives) and drives.in_doubt(joint) for drives in found)
        return replace(figures_of(moved.recording, motion, joint), in_doubt=in_doubt), motion

    def _with_payload(self, before: AxisFigures, mass: float) -> AxisFigures:
        bench, joint = replace(self.bench, payload=mass), before.joint
        if not bench.simulated:
            say(f"fix {mass:g} kg to the middle of the platform, then press Enter (drives are off)")
            sys.stdin.readline()
        seen, motion = self._swing(bench, joint)
        assert seen.weight is not None
        assert before.weight is not None
        expected = share_of_payload(bench.rig, motion, joint, mass)
        return replace(before, payload=(seen.weight - before.weight) / expected)

    def _with_stop(self, before: AxisFigures) -> AxisFigures:
        """The figures with those of a quick stop from slow motion, as far as the drive can show them."""
        if self.bench.rig.bus.transport != "canopen":
            return before
        try:
            try:
                return self._stopped(before, _SPEED / _STOP_TIME)
            except TooCoarse as error:
                if error.nearest > _SPEED * self.bench.rig.rate / _STOP_ROWS:
                    raise
                return self._stopped(before, error.nearest)
        except BadInput as error:
            say(f"joint {before.joint}: no quick stop was made: {error}")
            return before

    def _stopped(self, before: AxisFigures, commanded: float) -> AxisFigures:
        """The figures with those of a quick stop at a deceleration [rad/s^2 or m/s^2]."""
        rig, joint = self.bench.rig, before.joint
        gentle = rig.model_copy(update={"limits": rig.limits.model_copy(update={"acceleration": commanded})})
        polled: list[PolledVelocity] = []

        def prepare(drives: Amplifiers) -> None:
            assert isinstance(drives, CanopenDrives)
            polled.extend(filter(None, [drives.poll_velocity(joint)]))

        def plan(pose: Floats) -> Trajectory:
            middle = (rig.limits.joint_min + rig.limits.joint_max) / 2
            return jog(gentle, pose, joint, _WAY if pose[joint - 1] < middle else -_WAY, _SPEED)

        half = len(plan(middle_pose(rig)).repeat) // 2
        moved = move(replace(self.bench, rig=gentle), plan, None, self.log, stop_at=half, prepare=prepare)
        if not (moved.error or "").startswith(STOPPED_TO_SEE):
            raise RunFailed(f"{moved.error or 'the motion was not stopped'}{moved.contradiction(joint)}")
        stop = stop_deceleration(moved.recording, joint)
        seen = replace(before, deceleration=None if stop is None else stop / commanded)
        for velocity in polled:
            ratio = velocity_over_slope(velocity, moved.recording, joint)
            seen = replace(seen, velocity=ratio, velocity_rounding=abs(velocity.unit) / 2 / _SPEED)
        return seen

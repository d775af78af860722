"""Sign, scale and unit of one axis, judged from a recorded swing of its joint: contradictions are named.

The torque of a swing has three parts: weight (its mean), inertia (in phase with the acceleration) and friction (in
phase with the speed). Friction never drives, which shows the polarity of the torque. The weight of a delta robot with
the masses of the rig file shows the direction of the joint and the torque gain, and weight against inertia shows how
far the joint really moves: the weight does not depend on the size of the motion, the inertia does.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.protocol import CheckResult, Verdict
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Recording
from recordings.rig import Rig
from trajectories import Trajectory
from trajectories.checks import torque_estimate

Cycles = NDArray[np.intp]
_AGREES = 2.0
"""Factor by which the torque may differ from that of the rig file's masses."""
_SAME_TRAVEL = 1.6
"""Factor by which the travel of the joint may differ from the command: encoders are confused by 2 and more."""
_FOLLOWS = (0.8, 1.2)
"""Measured over commanded motion."""
_STANDS_OUT = 0.02
"""Share of the torque below which a part of it has no sign."""
_LEAST_WEIGHT = 0.05
"""Share of the torque below which the weight says nothing about the gain."""


@dataclass(frozen=True)
class AxisFigures:
    """What the swing of one joint showed."""

    joint: int
    """1 ... n."""
    travel: float
    """Measured over commanded motion, by the drive's own encoder."""
    friction: float
    """Mean friction torque against the motion [N m]; negative: it drives."""
    weight: float | None
    """Measured weight over that of the masses in the rig file; None: the rig file has none."""
    inertia: float | None
    """Likewise; the ratio inertia / weight is the true motion over the commanded one."""
    scatter: float
    """Root mean square of what these parts leave of the torque [N m]."""
    torque: float
    """Root mean square of the torque [N m]."""


def figures_of(recording: Recording, swing: Trajectory, joint: int) -> AxisFigures:
    """Figures of `joint` (1 ... n) from the recording of `swing`, as far as it went.

    Raises:
        BadInput: the joint did not move, or too little of the torque was recorded.
    """
    j, sent = joint - 1, np.flatnonzero(recording.repeat[:-1] >= 0)
    cycles = np.flatnonzero(swing.repeat >= 0)[: len(sent)]
    # A target is reached at the next SYNC.
    torque, position = torque_of(recording)[sent + 1, j], recording.position[sent + 1, j]
    command = recording.command[sent, j]
    known: Bools = np.isfinite(torque) & np.isfinite(command) & np.isfinite(position)
    if np.count_nonzero(known) < len(swing.repeat) // 10:
        raise BadInput(
            f"joint {joint}: a recorded swing expected, {np.count_nonzero(known)} samples found; try again"
        )
    velocity, acceleration = swing.joint_velocity[cycles, j], swing.joint_acceleration[cycles, j]
    parts = _parts(recording.rig, swing, cycles, j)
    has_model = parts is not None
    weight, inertia = parts or (np.ones(len(cycles)), acceleration)
    slow = np.abs(velocity) < _STANDS_OUT * np.abs(velocity).max()
    columns = np.column_stack([weight, inertia, np.sign(velocity), velocity])
    used = known & ~slow
    solution = np.linalg.lstsq(columns[used], torque[used], rcond=None)[0]
    friction = columns[used, 2:] @ solution[2:]
    return AxisFigures(
        joint=joint,
        travel=float(np.polyfit(command[known], position[known], 1)[0]),
        friction=float(np.mean(friction * np.sign(velocity[used]))),
        weight=float(solution[0]) if has_model else None,
        inertia=float(solution[1]) if has_model else None,
        scatter=float(np.sqrt(np.mean((torque[used] - columns[used] @ solution) ** 2))),
        torque=float(np.sqrt(np.mean(torque[used] ** 2))),
    )


def torque_of(recording: Recording) -> Floats:
    """Joint torque (n, dof) [N m or N]: as the drives report it, else from the voltage by the rig's torque map."""
    if recording.effort is not None:
        return recording.effort
    volts, torque = recording.voltage, recording.rig.torque
    return np.asarray(torque.gain) * (volts * np.abs(volts) if torque.map == "square" else volts)


def _parts(rig: Rig, swing: Trajectory, cycles: Cycles, j: int) -> tuple[Floats, Floats] | None:
    """Torque of weight and of inertia (n,) by the masses of the rig file; None where it has none."""
    if rig.mechanism != "delta":
        return None
    still = np.zeros_like(swing.joint_velocity)
    weight = torque_estimate(replace(swing, joint_velocity=still, joint_acceleration=still), rig)[cycles, j]
    return weight, torque_estimate(swing, rig)[cycles, j] - weight


def judge(figures: AxisFigures, rig: Rig) -> Iterator[CheckResult]:
    """Compare the figures with the rig file; contradictions are problems."""
    where, drive = f"joint {figures.joint}", rig.drives[figures.joint - 1]

    def result(what: str, expected: str, seen: str, verdict: Verdict) -> CheckResult:
        return CheckResult(where, what, expected, seen, verdict)

    if figures.travel < 0:
        yield result(
            "position", "follows the command", "runs against the command: encoder or motor phases", "problem"
        )
        return
    follows = _FOLLOWS[0] <= figures.travel <= _FOLLOWS[1]
    yield result("position", "follows the command", f"{figures.travel:.0%} of it", "fine" if follows else "problem")
    stands_out = abs(figures.friction) > _STANDS_OUT * figures.torque
    polarity = -1.0 if stands_out and figures.friction < 0 else 1.0
    text = f"{figures.friction:.2f} N m of friction"
    if polarity < 0:
        text += " drive the motion: the torque counts against the position, turn its polarity in the drive"
    elif not stands_out:
        text += ": too little to tell"
    yield result("torque against speed", "friction brakes", text, "problem" if polarity < 0 else "fine")
    if figures.weight is None or figures.inertia is None:
        text = "no masses in the rig file: compare the travel with your eyes, and the torque with a known weight"
        yield result("weight and inertia", "as the rig file says", text, "noted")
        return
    weight, inertia = polarity * figures.weight, polarity * figures.inertia
    if weight < -_LEAST_WEIGHT:
        text = (
            f"{weight:.2f} of the weight: gravity pulls the other way; sign = {-drive.sign}, or zero_offset is wrong"
        )
        yield result("weight", "gravity lowers the elbow", text, "problem")
        return
    if weight < _LEAST_WEIGHT:
        yield result("weight", "as of the masses", "none seen: is the torque object alive?", "problem")
        return
    agrees = 1 / _AGREES <= weight <= _AGREES
    text = f"{weight:.2f} times"
    if not agrees:
        gain = rig.torque.gain[figures.joint - 1]
        text += f": the torque gain is off, or the masses; torque.gain = {gain / weight:.3g} would agree"
    yield result(
        "weight", f"1/{_AGREES:g} to {_AGREES:g} times that of the masses", text, "fine" if agrees else "problem"
    )
    travel = inertia / weight
    same = 1 / _SAME_TRAVEL <= travel <= _SAME_TRAVEL
    text = f"{travel:.2f} times"
    if not same:
        text += (
            f": counts_per_turn times gear is {drive.counts_per_turn * drive.gear:g} in the rig file, about "
            f"{drive.counts_per_turn * drive.gear / abs(travel):.3g} would agree"
        )
    expected = f"1/{_SAME_TRAVEL:g} to {_SAME_TRAVEL:g} times the command"
    yield result("true travel, by inertia over weight", expected, text, "fine" if same else "problem")

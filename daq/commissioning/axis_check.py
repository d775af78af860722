"""Sign, scale and unit of one axis, judged from a recorded swing of its joint: contradictions are named.

The torque of a swing has three parts: weight (its mean), inertia (in phase with the acceleration) and friction (in
phase with the speed). Friction never drives, which shows the polarity of the torque. The weight of a delta robot with
the masses of the rig file shows the direction of the joint and the torque gain, and weight against inertia shows how
far the joint really moves: the weight does not depend on the size of the motion, the inertia does.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from daq.commissioning.rig_edit import RigChange
from drivers import cia402
from drivers.canopen.poll import PolledVelocity
from drivers.protocol import CheckResult, Verdict
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Recording
from recordings.rig import Drive, Rig
from trajectories import Trajectory
from trajectories.checks import torque_estimate

Cycles = NDArray[np.intp]
_AGREES = 2.0
"""Factor by which the torque may differ from that of the rig file's masses."""
_SAME_TRAVEL = 1.6
"""Factor by which the travel of the joint may differ from the command: encoders are confused by 2 and more."""
_PROVED = 1.1
"""Factor by which a quantity may differ from a reference from outside."""
_SAME_STOP = 1.25
"""Factor by which the deceleration of a quick stop may differ from its command: units differ by 2 pi and more."""
_LEAST_STOP = 0.002
"""Deceleration over its command below which the joint hardly slows down, and its size is not known."""
_PART_OF_STOP = (0.1, 0.9)
"""Part of the way of a stop in which the deceleration is steady."""
_LEAST_ROWS = 4
"""Samples that show a deceleration."""
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
    friction: float | None
    """Mean friction torque against the motion [N m]; negative: it drives; None: no torque is recorded, and no part of
    it is known."""
    weight: float | None
    """Measured weight over that of the masses in the rig file; None: the rig file has none."""
    inertia: float | None
    """Likewise; the ratio inertia / weight is the true motion over the commanded one."""
    scatter: float | None
    """Root mean square of what these parts leave of the torque [N m]."""
    torque: float | None
    """Root mean square of the torque [N m]."""
    true_travel: float | None = None
    """True motion over that of the encoder; None: nobody measured it."""
    payload: float | None = None
    """Measured over expected weight of a known mass; None: none was fixed to the robot."""
    deceleration: float | None = None
    """Measured over commanded deceleration of a quick stop; None: none was seen."""
    velocity: float | None = None
    """Velocity actual (606Ch) by the drive's unit over the derivative of 6064h; None: not both are there."""
    velocity_rounding: float = 0.0
    """Half a unit of 606Ch over the speed."""
    in_doubt: bool = False
    """Whether the drive states two units of position, of which none was decided before."""


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
    known: Bools = np.isfinite(command) & np.isfinite(position)
    if recording.rig.drives[j].torque_source == "none":
        travel = float(np.polyfit(command[known], position[known], 1)[0])
        return AxisFigures(joint, travel, friction=None, weight=None, inertia=None, scatter=None, torque=None)
    known &= np.isfinite(torque)
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


def share_of_payload(rig: Rig, swing: Trajectory, joint: int, mass: float) -> float:
    """Weight that a `mass` [kg] on the platform adds to that of the masses in the rig file, as a share of it."""
    loaded = rig.model_copy(update={"nominal": rig.nominal.model_copy(update={"m_p": rig.nominal.m_p + mass})})
    cycles = np.flatnonzero(swing.repeat >= 0)
    weights = [parts[0].mean() for each in (rig, loaded) if (parts := _parts(each, swing, cycles, joint - 1))]
    return float(weights[1] / weights[0] - 1)


def stop_deceleration(recording: Recording, joint: int) -> float | None:
    """Deceleration of `joint` (1 ... n) in a quick stop [rad/s^2], between a tenth and nine tenths of its way; None
    where no drive said that it stopped (6041h) or nothing moved."""
    words = recording.statusword[:, joint - 1].tolist()
    stopping = [cia402.decode(word) is cia402.DriveState.QUICK_STOP for word in words]
    known = np.isfinite(recording.position[:, joint - 1])
    rows = np.flatnonzero(known & (np.cumsum(stopping) > 0))
    if len(rows) < _LEAST_ROWS:
        return None
    position, time = recording.position[rows, joint - 1], rows / recording.run.rate
    way = (position - position[0]) / ((position[-1] - position[0]) or math.inf)
    moving = (way > _PART_OF_STOP[0]) & (way < _PART_OF_STOP[1])
    if np.count_nonzero(moving) < _LEAST_ROWS:
        # It stood almost at once: as hard as the time between two answers can show.
        before = recording.position[rows[0] - 2 : rows[0] + 1, joint - 1]
        speed = abs(float(before[-1] - before[0])) * recording.run.rate / 2
        return speed * recording.run.rate / 2 if speed else None
    return float(abs(2 * np.polyfit(time[moving], position[moving], 2)[0]))


def velocity_over_slope(velocity: PolledVelocity, recording: Recording, joint: int) -> float | None:
    """606Ch of `joint` (1 ... n) by the drive's unit over the derivative of 6064h, both summed up over the recording;
    None where the drive has no 606Ch or nothing moved."""
    position = recording.position[:, joint - 1]
    first, last = position[np.isfinite(position)][[0, -1]]
    if not velocity.values or first == last:
        return None
    times = (np.array(velocity.stamps) - velocity.stamps[0]) * 1e-9
    return float(np.trapezoid(velocity.values, times) * velocity.unit / (last - first))


def judge(figures: AxisFigures, rig: Rig) -> Iterator[CheckResult]:
    """Compare the figures with the rig file: each quantity is proved, consistent, not shown, or a problem."""
    yield from _judge_swing(figures, rig)
    where, stop = f"joint {figures.joint}", figures.deceleration
    if stop is None:
        text = "no quick stop was seen" if figures.travel > 0 else "the swing failed"
        yield CheckResult(where, "unit of the quick stop", "as commanded", text, "not shown")
    else:
        right = 1 / _SAME_STOP <= stop <= _SAME_STOP
        text = f"{stop:.2f} times, measured by position"
        if not right:
            text += ": the unit of 6085h is another one; see units of this drive in the rig file"
        yield CheckResult(where, "unit of the quick stop", "as commanded", text, "proved" if right else "problem")
    yield _judge_velocity(figures)


def _judge_velocity(figures: AxisFigures) -> CheckResult:
    result = partial(CheckResult, f"joint {figures.joint}", "unit of 606Ch", "as 60A9h says")
    if figures.velocity is None:
        return result("no 606Ch, no unit that the drive states, or no room on the bus", "not shown")
    text = f"{figures.velocity:.3g} times the derivative of 6064h"
    if abs(figures.velocity - 1) > _PROVED - 1 + figures.velocity_rounding:
        text += ": 60A9h is wrong; leave speed and zero_speed out of homing, which are written in this unit"
        return result(text, "problem")
    if figures.velocity_rounding > _PROVED - 1:
        return result(f"{text}, of which one unit is too large a part", "not shown")
    return result(text, "proved")


def _judge_swing(figures: AxisFigures, rig: Rig) -> Iterator[CheckResult]:
    where, drive = f"joint {figures.joint}", rig.drives[figures.joint - 1]

    result = partial(CheckResult, where)
    if figures.travel < 0:
        yield result(
            "position", "follows the command", "runs against the command: encoder or motor phases", "problem"
        )
        return
    follows = _FOLLOWS[0] <= figures.travel <= _FOLLOWS[1]
    yield result(
        "position", "follows the command", f"{figures.travel:.0%} of it", "consistent" if follows else "problem"
    )
    shown: Verdict
    text, shown, friction = 'torque_source = "none": no torque is recorded', "not shown", figures.friction
    if friction is not None and figures.torque is not None:
        text, shown = _friction(friction, abs(friction) > _STANDS_OUT * figures.torque)
    yield result("torque against speed", "friction brakes", text, shown)
    if figures.true_travel is not None:
        yield result(*_travel(figures.true_travel, drive, _PROVED, "measured from outside", "proved"))
    if figures.weight is None or figures.inertia is None:
        text = "no masses in the rig file: compare the travel with your eyes, and the torque with a known weight"
        yield result("weight and inertia", "as the rig file says", text, "not shown")
        return
    yield from _judge_weight(figures, -1.0 if shown == "problem" else 1.0, rig)


def _friction(friction: float, stands_out: bool) -> tuple[str, Verdict]:
    text = f"{friction:.2f} N m of friction"
    if not stands_out:
        return f"{text}: too little to tell", "not shown"
    if friction < 0:
        text += " drive the motion: the torque counts against the position, turn its polarity in the drive"
        return text, "problem"
    return text, "proved"


def _judge_weight(figures: AxisFigures, polarity: float, rig: Rig) -> Iterator[CheckResult]:
    """Judge what the weight shows; `polarity`: -1 where the torque counts against the position."""
    assert figures.weight is not None
    assert figures.inertia is not None
    drive, result = rig.drives[figures.joint - 1], partial(CheckResult, f"joint {figures.joint}")
    weight, inertia = polarity * figures.weight, polarity * figures.inertia
    if weight < -_LEAST_WEIGHT:
        text = (
            f"{weight:.2f} of the weight: gravity pulls the other way; sign = {-drive.sign}, or zero_offset is wrong"
        )
        yield result("direction of the joint", "gravity lowers the elbow", text, "problem")
        return
    if weight < _LEAST_WEIGHT:
        yield result("weight", "as of the masses", "none seen: is the torque object alive?", "problem")
        return
    yield result("direction of the joint", f"sign = {drive.sign}", "gravity lowers the elbow", "proved")
    reference, factor = ("masses", _AGREES) if figures.payload is None else ("known mass", _PROVED)
    weight = figures.weight if figures.payload is None else figures.payload
    weight *= polarity
    agrees = 1 / factor <= weight <= factor
    text = f"{weight:.2f} times"
    if not agrees:
        gain = rig.torque.gain[figures.joint - 1]
        text += f": the torque gain is off, or the masses; torque.gain = {gain / weight:.3g} would agree"
    verdict: Verdict = "proved" if 1 / _PROVED <= weight <= _PROVED else "consistent"
    expected = f"1/{factor:g} to {factor:g} times that of the {reference}"
    yield result("weight", expected, text, verdict if agrees else "problem")
    if figures.true_travel is None:
        yield result(
            *_travel(inertia / (polarity * figures.weight), drive, _SAME_TRAVEL, "inertia over weight", "consistent")
        )


def _travel(
    travel: float, drive: Drive, factor: float, reference: str, otherwise: Verdict
) -> tuple[str, str, str, Verdict]:
    same = 1 / factor <= travel <= factor
    text = f"{travel:.2f} times"
    if not same:
        product = drive.counts_per_turn * drive.gear
        right = f"about {product / abs(travel):.3g} would agree"
        text += f": counts_per_turn times gear is {product:g} in the rig file, {right}"
    expected = f"1/{factor:g} to {factor:g} times the command"
    return f"true travel, by {reference}", expected, text, otherwise if same else "problem"


def changes(judged: Sequence[tuple[AxisFigures, Sequence[CheckResult]]], rig: Rig) -> Iterator[RigChange]:
    """Values of the rig file with which the contradictions of all joints go away, where a value is known."""
    gains: dict[int, float] = {}
    for figures, results in judged:
        wrong = {result.what for result in results if result.verdict == "problem"}
        drive = partial(RigChange, "[[drives]]", figures.joint - 1)
        own, weight = rig.drives[figures.joint - 1], figures.weight if figures.payload is None else figures.payload
        travel = figures.true_travel
        if travel is None and figures.weight and figures.inertia is not None:
            travel = figures.inertia / figures.weight
        if travel and any(what.startswith("true travel") for what in wrong):
            yield drive("counts_per_turn", str(round(own.counts_per_turn / abs(travel))))
        if "direction of the joint" in wrong:
            yield drive("sign", str(-own.sign))
        if "weight" in wrong and weight:
            gains[figures.joint - 1] = abs(weight)
        unit, stop = own.units.acceleration, figures.deceleration or 0.0
        if stop > _LEAST_STOP and unit is not None and "unit of the quick stop" in wrong:
            number, _, name = unit.rpartition(" ")
            yield drive("units", f'{{ acceleration = "{float(number or 1) * stop:.4g} {name}" }}')
    yield from _gains(gains, rig)


def measured(judged: Sequence[tuple[AxisFigures, Sequence[CheckResult]]]) -> Iterator[RigChange]:
    """Changes that mark a unit of position in doubt as measured: of joints that moved as far as commanded."""
    for figures, results in judged:
        shown = any(r.what.startswith("true travel") and r.verdict in ("proved", "consistent") for r in results)
        if shown and figures.in_doubt:
            yield RigChange("[[drives]]", figures.joint - 1, "counts_source", '"measured"')


def _gains(factors: dict[int, float], rig: Rig) -> Iterator[RigChange]:
    """Torque gains divided by the `factors` of some joints (0 ... n - 1), wherever the rig has them."""
    keys = {"voltage": "gain", "current_actual": "per_ampere", "torque_actual": "rated_torque"}
    key_of = [keys.get(drive.torque_source) for drive in rig.drives]
    for key, present in (("gain", rig.torque.gain), ("per_ampere", rig.torque.per_ampere)):
        own = {j: factor for j, factor in factors.items() if key_of[j] == key}
        if own:
            values = (f"{value / own.get(j, 1.0):.4g}" for j, value in enumerate(present))
            yield RigChange("[torque]", 0, key, f"[{', '.join(values)}]")
    for j, factor in factors.items():
        if key_of[j] == "rated_torque":
            yield RigChange("[[drives]]", j, "rated_torque", f"{rig.drives[j].rated_torque / factor:.4g}")

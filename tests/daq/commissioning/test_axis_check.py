"""The swing of one axis: figures of a perfect one, and every contradiction is named."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.bench import Bench
from daq.commissioning.axis_check import AxisFigures, figures_of, judge
from daq.commissioning.small_motion import move
from daq.simulation import simulated
from drivers.simulated.config import SimConfig
from recordings.recording import Floats, Recording
from recordings.rig import Axis, Drive, Rig, simulated_rig
from tests.made_up import run_of
from trajectories import Trajectory
from trajectories.checks import torque_estimate
from trajectories.multisine import middle_pose
from trajectories.small_moves import swing

RIG = simulated_rig().at_rate(100.0)
FRICTION = 0.8


def recording_of(
    rig: Rig, motion: Trajectory, joint: int, weight: float = 1.0, inertia: float = 1.0, polarity: float = 1.0
) -> Recording:
    """A drive that reaches every target at the next SYNC; the torque has these factors."""
    j, still = joint - 1, np.zeros_like(motion.joint_velocity)
    own_weight = torque_estimate(replace(motion, joint_velocity=still, joint_acceleration=still), rig)
    parts = weight * own_weight + inertia * (torque_estimate(motion, rig) - own_weight)
    torque = polarity * (parts + FRICTION * np.sign(motion.joint_velocity))
    noise = np.random.default_rng(j).normal(0, 0.01, torque.shape)
    return as_recording(rig, motion, np.sign(torque) * np.sqrt(np.abs(torque)) + noise)


def as_recording(rig: Rig, motion: Trajectory, voltage: Floats) -> Recording:
    n = len(motion.repeat)
    before = np.r_[0, : n - 1]
    words = np.zeros((n, rig.dof), dtype=np.uint16)
    return Recording(
        Path("axis.mcap"),
        rig,
        run_of(period=1.0, cycles=1, rate=rig.rate),
        *(motion.time, motion.joint_position[before], motion.joint_position, voltage[before]),
        *(None, None, words, words, motion.repeat, np.zeros(n), ()),
    )


def problems(figures: AxisFigures, rig: Rig = RIG) -> str:
    return " | ".join(f"{r.what}: {r.found}" for r in judge(figures, rig) if r.verdict == "problem")


@pytest.mark.parametrize("joint", [1, 2, 3])
def test_figures_of_an_axis_that_is_as_the_rig_file_says(joint: int) -> None:
    motion = swing(RIG, middle_pose(RIG), joint, 0.05)
    figures = figures_of(recording_of(RIG, motion, joint), motion, joint)
    assert figures.travel == pytest.approx(1, abs=1e-6)
    assert figures.weight == pytest.approx(1, abs=0.02)
    assert figures.inertia == pytest.approx(1, abs=0.05)
    assert figures.friction == pytest.approx(FRICTION, rel=0.05)
    assert problems(figures) == ""


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"weight": 2.5, "inertia": 2.5}, "torque.gain = 0.4 would agree"),
        ({"weight": 0.4, "inertia": 0.4}, "torque.gain = 2.5 would agree"),
        ({"inertia": 4.0}, "counts_per_turn times gear is 172032 in the rig file"),
        ({"inertia": 0.4}, "true travel"),
        ({"polarity": -1.0}, "turn its polarity in the drive"),
        ({"weight": -1.0}, "gravity pulls the other way; sign = -1"),
        ({"weight": 0.0, "inertia": 0.0}, "none seen"),
    ],
)
def test_contradiction_is_named(changes: dict[str, Any], expected: str) -> None:
    motion = swing(RIG, middle_pose(RIG), 1, 0.05)
    text = problems(figures_of(recording_of(RIG, motion, 1, **changes), motion, 1))
    assert expected in text
    assert "|" not in text
    assert "runs against the command" in problems(AxisFigures(1, -0.9, 0.8, 1.0, 1.0, 0.1, 4.0))


def test_single_axis_has_no_masses_to_compare_with() -> None:
    rig = Rig(name="axis", mechanism="axes", axes=(Axis(),), drives=(Drive(node_id=1),), rate=100.0)
    motion = swing(rig, np.zeros(1), 1, 0.05)
    torque = 0.3 * motion.joint_acceleration + FRICTION * np.sign(motion.joint_velocity)
    figures = figures_of(as_recording(rig, motion, np.sign(torque) * np.sqrt(np.abs(torque))), motion, 1)
    assert (figures.weight, figures.inertia) == (None, None)
    assert figures.friction == pytest.approx(FRICTION, rel=0.05)
    (note,) = [result for result in judge(figures, rig) if result.verdict != "fine"]
    assert note.verdict == "noted"


@dataclass(frozen=True, kw_only=True)
class WrongBench(Bench):
    """A machine that is not what the rig file says."""

    true: Rig
    config: SimConfig

    @contextmanager
    def serve(self, recording: Path | None = None) -> Iterator[None]:
        with simulated(self.true, self.config, self.pace, 0):
            yield


def with_drives(rig: Rig, **changes: Any) -> Rig:
    return rig.model_copy(update={"drives": tuple(d.model_copy(update=changes) for d in rig.drives)})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("true", "config", "expected"),
    [
        (RIG, SimConfig(), ""),
        (with_drives(RIG, sign=-1), SimConfig(), "sign = -1"),
        (with_drives(RIG, counts_per_turn=2048), SimConfig(), "counts_per_turn"),
        (RIG, SimConfig(torque_gain=(3.0, 3.0, 3.0)), "torque.gain"),
    ],
)
def test_simulated_machine_that_is_not_as_the_rig_file_says(true: Rig, config: SimConfig, expected: str) -> None:
    machine = WrongBench(RIG, "lockstep", true=true, config=config)
    plan = lambda pose: swing(RIG, pose, 1, 0.05)  # noqa: E731
    moved = move(machine, plan, None, lambda *line: None, hold=None, status=False)
    text = problems(figures_of(moved.recording, plan(moved.pose), 1))
    assert expected in text
    assert bool(expected) == bool(text)

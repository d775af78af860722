"""The swing of one axis: figures of a perfect one, and every contradiction is named."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.bench import Bench
from daq.commissioning.axis_check import (
    AxisFigures,
    changes,
    figures_of,
    judge,
    measured,
    share_of_payload,
    stop_deceleration,
    velocity_over_slope,
)
from daq.commissioning.axis_swings import AxisSwings
from daq.commissioning.rig_edit import RigChange, write_changes
from daq.commissioning.small_motion import Moved, Plan
from drivers.canopen.poll import PolledVelocity
from recordings.drives import AssumedUnits
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Axis, Drive, Rig, simulated_rig
from tests.conftest import Runner
from tests.made_up import run_of
from trajectories import Trajectory
from trajectories.checks import torque_estimate
from trajectories.multisine import middle_pose
from trajectories.small_moves import jog, swing

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
    ("factors", "expected"),
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
def test_contradiction_is_named(factors: dict[str, Any], expected: str) -> None:
    motion = swing(RIG, middle_pose(RIG), 1, 0.05)
    text = problems(figures_of(recording_of(RIG, motion, 1, **factors), motion, 1))
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
    assert {result.what: result.verdict for result in judge(figures, rig)} == {
        "position": "consistent",
        "torque against speed": "proved",
        "weight and inertia": "not shown",
        "unit of the quick stop": "not shown",
        "unit of 606Ch": "not shown",
    }


def test_without_a_torque_nothing_is_said_of_it() -> None:
    drive = Drive(node_id=1, torque_source="none")
    rig = Rig(name="axis", mechanism="axes", axes=(Axis(),), drives=(drive,), rate=100.0)
    motion = swing(rig, np.zeros(1), 1, 0.05)
    figures = figures_of(as_recording(rig, motion, np.full((len(motion.repeat), 1), np.nan)), motion, 1)
    assert (figures.friction, figures.torque, figures.scatter) == (None, None, None)
    results = {result.what: result for result in judge(figures, rig)}
    assert results["torque against speed"].verdict == "not shown"
    assert "no torque is recorded" in results["torque against speed"].found


SEEN = AxisFigures(2, 1.0, 0.8, 1.0, 1.0, 0.1, 4.0)
UNITS = "[[drives]]", 1, "units"
COUNTS = "[[drives]]", 1, "counts_per_turn"


@pytest.mark.parametrize(
    ("seen", "what", "verdict", "change"),
    [
        ({}, "weight", "proved", None),
        ({"weight": 1.5}, "weight", "consistent", None),
        ({"weight": 2.5, "inertia": 2.5}, "weight", "problem", RigChange("[torque]", 0, "gain", "[1, 0.4, 1]")),
        ({"weight": 1.5, "payload": 1.5}, "weight", "problem", RigChange("[torque]", 0, "gain", "[1, 0.6667, 1]")),
        ({"weight": 1.5, "payload": 1.02}, "weight", "proved", None),
        ({"weight": -1.0}, "direction of the joint", "problem", RigChange("[[drives]]", 1, "sign", "-1")),
        ({"inertia": 4.0}, "true travel, by inertia over weight", "problem", RigChange(*COUNTS, "2048")),
        ({"true_travel": 1.05}, "true travel, by measured from outside", "proved", None),
        ({"true_travel": 2.0}, "true travel, by measured from outside", "problem", RigChange(*COUNTS, "4096")),
        ({"deceleration": 1.1}, "unit of the quick stop", "proved", None),
        (
            {"deceleration": 33.0},
            "unit of the quick stop",
            "problem",
            RigChange(*UNITS, '{ acceleration = "33 rpm/s" }'),
        ),
        ({}, "unit of the quick stop", "not shown", None),
        ({"velocity": 1.08, "velocity_rounding": 0.01}, "unit of 606Ch", "proved", None),
        ({"velocity": 0.85, "velocity_rounding": 0.2}, "unit of 606Ch", "not shown", None),
        ({"velocity": 0.85, "velocity_rounding": 0.01}, "unit of 606Ch", "problem", None),
        ({"velocity": 0.007, "velocity_rounding": 0.01}, "unit of 606Ch", "problem", None),
        ({}, "unit of 606Ch", "not shown", None),
    ],
)
def test_each_quantity_has_its_verdict_and_its_remedy(
    seen: dict[str, float], what: str, verdict: str, change: RigChange | None
) -> None:
    rig = with_drives(RIG, units=AssumedUnits(acceleration="rpm/s"))
    figures = replace(SEEN, **seen)
    results = list(judge(figures, rig))
    assert {result.what: result.verdict for result in results}[what] == verdict
    assert list(changes([(figures, results)], rig)) == ([] if change is None else [change])


@pytest.mark.parametrize(
    ("seen", "shown"),
    [
        ({}, True),
        ({"in_doubt": False}, False),
        ({"inertia": 4.0}, False),
        ({"true_travel": 1.05}, True),
        ({"weight": None}, False),
    ],
)
def test_a_travel_that_was_shown_decides_a_doubt(seen: dict[str, Any], shown: bool) -> None:
    figures = replace(SEEN, **({"in_doubt": True} | seen))
    change = RigChange("[[drives]]", 1, "counts_source", '"measured"')
    assert list(measured([(figures, list(judge(figures, RIG)))])) == ([change] if shown else [])


def test_what_is_true_of_every_motion_is_said_once(capsys: pytest.CaptureFixture[str]) -> None:
    swings = AxisSwings(Bench(RIG, "lockstep"), 0.05)
    for joint in (1, 1, 2):
        swings.log("warning", f"joint {joint}", "either may be right")
    assert capsys.readouterr().err.splitlines() == [
        "warning: joint 1: either may be right",
        "warning: joint 2: either may be right",
    ]


def test_a_simulated_rig_is_named_once_and_every_swing_before_it_begins(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def moved(bench: Bench, plan: Plan, *_: object, stop_at: int | None = None, **__: object) -> Moved:
        if stop_at is not None:
            raise BadInput("too soft")
        return Moved(recording_of(RIG, plan(middle_pose(RIG)), 1), None, released=False)

    monkeypatch.setattr("daq.commissioning.axis_swings.move", moved)
    AxisSwings(Bench(RIG, "lockstep"), 0.05).figures([1, 3], None, 1.5)
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("SIMULATED RIG")
    assert said[1] == f"{RIG.name}: joint 1 by ±0.05 rad, joint 3 by ±0.05 rad, lockstep"
    swings = [line for line in said[2:] if "quick stop" not in line]
    assert swings == [f"swinging joint {joint} by ±0.05 rad" for joint in (1, 3, 1, 3)]


def test_the_share_of_a_known_mass_is_that_of_its_weight() -> None:
    motion = swing(RIG, middle_pose(RIG), 1, 0.05)
    heavy = RIG.model_copy(update={"nominal": RIG.nominal.model_copy(update={"m_p": RIG.nominal.m_p + 1.5})})
    figures = figures_of(recording_of(heavy, motion, 1), motion, 1)
    assert figures.weight is not None
    recorded = replace(recording_of(heavy, motion, 1), rig=RIG)
    loaded = figures_of(recorded, motion, 1).weight
    assert loaded is not None
    assert loaded - 1 == pytest.approx(share_of_payload(RIG, motion, 1, 1.5), rel=0.1)


@pytest.mark.parametrize("deceleration", [0.125, 0.5, 8.0])
def test_the_deceleration_of_a_quick_stop_is_measured_by_position(deceleration: float) -> None:
    rig = RIG.at_rate(500.0)
    still, speed, n = 100, 0.05, 800
    time = np.arange(n) / rig.rate
    stopping = np.clip(time - time[still], 0, speed / deceleration)
    way = speed * np.minimum(time, time[still]) + speed * stopping - deceleration * stopping**2 / 2
    position = np.tile(RIG.drives[0].to_position(np.round(RIG.drives[0].to_counts(way)))[:, None], (1, 3))
    motion = swing(rig, middle_pose(rig), 1, 0.05)
    recording = as_recording(rig, motion, np.zeros_like(motion.joint_position))
    words = np.where(np.arange(n) >= still, 0x07, 0x27).astype(np.uint16)
    recording = replace(recording, position=position, statusword=np.tile(words[:, None], (1, 3)))
    measured = stop_deceleration(recording, 1)
    assert measured is not None
    if deceleration < 1:
        assert measured == pytest.approx(deceleration, rel=0.15)
    else:  # it stands after three samples
        assert measured > 1


def test_velocity_is_compared_with_the_slope_of_the_position() -> None:
    motion = jog(RIG, middle_pose(RIG), 1, 0.2)
    recording = as_recording(RIG, motion, np.zeros_like(motion.joint_position))
    stamps, values = (1e9 * motion.time).astype(int), np.rint(1e3 * motion.joint_velocity[:, 0]).astype(int)
    velocity = PolledVelocity(0.06, stamps[::3].tolist(), values[::3].tolist())
    assert velocity_over_slope(velocity, recording, 1) == pytest.approx(60, rel=0.01)
    assert velocity_over_slope(velocity, recording, 2) is None
    assert velocity_over_slope(PolledVelocity(0.06), recording, 1) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("habits", "rate", "verdict", "found"),
    [
        ("", 250, "proved", " times the derivative of 6064h"),
        ("velocity_factor = 60", 250, "problem", "60 times the derivative of 6064h: 60A9h is wrong"),
        ('values = { "60A9" = 0 }', 250, "not shown", "no 606Ch, no unit"),
        ("velocity_factor = 60", 800, "not shown", "no room on the bus"),
    ],
)
def test_a_simulated_drive_shows_the_unit_of_its_velocity_where_the_bus_has_room(
    daq_in_process: Runner, tmp_path: Path, habits: str, rate: float, verdict: str, found: str
) -> None:
    (tmp_path / "sim.toml").write_text(f"[[drives]]\n[drives.habits]\n{habits}\n")
    done = daq_in_process("axis-check", "--joint", 1, "--rate", rate, "--sim", "sim.toml", "--json")
    results = {result["what"]: result for result in json.loads(done.out)["findings"]}
    assert results["unit of 606Ch"]["verdict"] == verdict
    assert found in results["unit of 606Ch"]["found"]
    assert results["unit of the quick stop"]["verdict"] == "proved"
    assert done.code == (verdict == "problem")


def test_a_rig_file_keeps_its_comments(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    text = """name = "bench"  # ours # indeed
[torque]
gain = [1, 1, 1]   # by the type plate
[[drives]] # left
node_id = 1
[[drives]]
node_id = 2
sign = 1 # by eye
[[drives]]
node_id = 3
"""
    file.write_text(text)
    write_changes(
        file,
        [
            RigChange("[torque]", 0, "gain", "[1, 0.4, 1]"),
            RigChange("[[drives]]", 1, "sign", "-1"),
            RigChange("[[drives]]", 2, "counts_per_turn", "4096"),
        ],
    )
    expected = text.replace("[1, 1, 1]", "[1, 0.4, 1]").replace("sign = 1", "sign = -1")
    assert file.read_text() == expected.replace(
        "[[drives]]\nnode_id = 3", "[[drives]]\ncounts_per_turn = 4096\nnode_id = 3"
    )
    with pytest.raises(BadInput, match="by hand"):
        write_changes(file, [RigChange("[[drives]]", 3, "sign", "1")])
    inline = "drives = [{ node_id = 1 }, { node_id = 2 }, { node_id = 3 }]\nname = 'b'\n"
    file.write_text(inline)
    with pytest.raises(BadInput, match="by hand"):
        write_changes(file, [RigChange("[[drives]]", 0, "sign", "-1")])
    assert file.read_text() == inline


def with_drives(rig: Rig, **keys: Any) -> Rig:
    return rig.model_copy(update={"drives": tuple(d.model_copy(update=keys) for d in rig.drives)})

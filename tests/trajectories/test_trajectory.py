"""Sampling, soft start and end, identical cycles."""

from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.rig import Axis, Geometry, Rig, simulated_rig
from trajectories import Trajectory, approach, load, names
from trajectories.checks import check
from trajectories.fourier import FourierSeries
from trajectories.kinematics import Unreachable, forward
from trajectories.motion import PlannedMotion
from trajectories.multisine import multisine
from trajectories.spline import through
from trajectories.trajectory import assemble


@pytest.fixture(scope="module")
def rig() -> Rig:
    return simulated_rig()


@pytest.fixture(scope="module", params=names())
def built_in(request: pytest.FixtureRequest, rig: Rig) -> Trajectory:
    return load(request.param, rig)


def circle(period: float = 4.0) -> PlannedMotion:
    return FourierSeries(
        kind="fourier",
        space="platform",
        period=period,
        centre=(0.0, 0.0, -0.7),
        cosine=((0.1,), (0.0,), (0.0,)),
        sine=((0.0,), (0.1,), (0.0,)),
    ).motion("circle")


def line(duration: float) -> PlannedMotion:
    time = np.linspace(0, duration, 9)
    points = np.column_stack([np.linspace(-0.1, 0.1, 9), np.zeros(9), np.full(9, -0.7)])
    return through("line", "a line", "platform", time, points)


def test_built_in_paths_keep_the_default_limits_with_margin(built_in: Trajectory, rig: Rig) -> None:
    limits = rig.limits
    tight = limits.model_copy(
        update={
            "joint_min": limits.joint_min + 0.1,
            "joint_max": limits.joint_max - 0.1,
            "speed": limits.speed / 2,
            "acceleration": limits.acceleration / 2,
            "torque": limits.torque / 2,
            "workspace_radius": limits.workspace_radius - 0.05,
            "workspace_z": (limits.workspace_z[0] + 0.05, limits.workspace_z[1] - 0.05),
            "singularity_margin": 4 * limits.singularity_margin,
        }
    )
    check(built_in, rig.model_copy(update={"limits": tight}))


def test_built_in_paths_move_every_joint_fast_and_often(built_in: Trajectory) -> None:
    cycle = built_in.repeat == 0
    speed = built_in.joint_velocity[cycle]
    assert (np.abs(speed).max(axis=0) > 2.0).all()
    reversals = np.diff(np.sign(speed), axis=0) != 0
    assert (reversals.sum(axis=0) >= 6).all()
    assert built_in.cycles >= 4
    assert len(built_in.time) / built_in.rate == pytest.approx(22, abs=1.5)


def test_cycles_are_identical_to_the_last_bit(built_in: Trajectory) -> None:
    first = built_in.repeat == 0
    for cycle in range(1, built_in.cycles):
        same = built_in.repeat == cycle
        for array in (
            built_in.platform,
            built_in.joint_position,
            built_in.joint_velocity,
            built_in.joint_acceleration,
        ):
            assert (array[same] == array[first]).all()


def test_cycles_stand_between_lead_in_and_lead_out_from_rest_to_rest(built_in: Trajectory, rig: Rig) -> None:
    changes = built_in.repeat[np.flatnonzero(np.diff(built_in.repeat, prepend=-2))]
    assert changes.tolist() == [-1, *range(built_in.cycles), -1]
    ends = [built_in.joint_velocity[[0, -1]], built_in.joint_acceleration[[0, -1]]]
    assert np.abs(ends).max() < 1e-12
    assert forward(rig.geometry, built_in.joint_position) == pytest.approx(built_in.platform, abs=1e-12)
    for rate in (200.0, 250.0, 400.0, 1000.0):
        cycle = load(built_in.name, rig, cycles=2, rate=rate).repeat == 0
        assert cycle.sum() == built_in.period * rate


def test_velocity_and_acceleration_are_the_derivatives_of_position(built_in: Trajectory) -> None:
    step = 1 / built_in.rate
    central = (built_in.joint_position[2:] - built_in.joint_position[:-2]) / (2 * step)
    assert central == pytest.approx(built_in.joint_velocity[1:-1], abs=2e-3)
    central = (built_in.joint_velocity[2:] - built_in.joint_velocity[:-2]) / (2 * step)
    assert central == pytest.approx(built_in.joint_acceleration[1:-1], abs=0.1)


def test_open_path_contains_its_ramps(rig: Rig) -> None:
    trajectory = assemble(line(3.0), rig)
    assert trajectory.cycles == 1
    assert trajectory.period == 0
    assert trajectory.platform[[0, -1], 0] == pytest.approx([-0.1, 0.1], abs=1e-12)
    assert trajectory.joint_velocity[[0, -1]] == pytest.approx(0, abs=1e-12)
    assert (trajectory.repeat == 0).sum() == pytest.approx(2.0 * rig.rate)
    assert np.abs(np.diff(trajectory.joint_velocity, axis=0)).max() < 0.01


def test_period_is_rounded_to_whole_samples(rig: Rig) -> None:
    trajectory = assemble(circle(period=3.3333), rig, cycles=2, rate=200)
    assert (trajectory.repeat == 0).sum() == 667
    assert trajectory.period == 667 / 200
    speed = np.linalg.norm(np.diff(trajectory.platform[trajectory.repeat == 0], axis=0), axis=1) * 200
    assert speed == pytest.approx(0.2 * np.pi / trajectory.period, rel=1e-4)


def test_unreachable_path_names_the_instant(rig: Rig) -> None:
    plunge = FourierSeries(
        kind="fourier",
        space="platform",
        period=4.0,
        centre=(0.0, 0.0, -0.9),
        cosine=((0.0,), (0.0,), (0.0,)),
        sine=((0.0,), (0.0,), (-0.3,)),
    ).motion("plunge")
    with pytest.raises(Unreachable, match=r"plunge, t = .* s: limb \d cannot reach") as caught:
        assemble(plunge, rig, cycles=3, rate=500)
    # Time at which the path reaches the lowest reachable height; the first repetition begins after one second.
    deepest = np.sqrt((rig.geometry.L1 + rig.geometry.L2) ** 2 - (rig.geometry.R - rig.geometry.r) ** 2)
    expected = 1.0 + 4.0 / (2 * np.pi) * np.arcsin((deepest - 0.9) / 0.3)
    error = float(str(caught.value).split("t = ")[1].split(" s")[0])
    assert expected <= error <= expected + 1 / 500 + 5e-4


def test_digest_changes_with_path_cycles_rate_and_geometry(rig: Rig) -> None:
    same = {name: load(name, rig).digest for name in names()}
    assert same["fig5a"] == load("fig5a", rig).digest
    other_geometry = rig.model_copy(update={"geometry": Geometry(L2=0.81)})
    changes = (load("fig5a", rig, cycles=2), load("fig5a", rig, rate=250), load("fig5a", other_geometry))
    assert len({*same.values(), *(changed.digest for changed in changes)}) == len(same) + 3


PAIR = FourierSeries(
    kind="fourier", space="joint", period=2.0, centre=(0.0, 0.0), cosine=((0.1,),) * 2, sine=((0.1,),) * 2
)
BENCH = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis(), Axis()))
REFUSED: dict[str, tuple[Callable[[Rig], object], str]] = {
    "cycles of an open path": (
        lambda rig: assemble(line(3.0), rig, cycles=2),
        "does not end where it begins.*close the path",
    ),
    "path shorter than its ramps": (lambda rig: assemble(line(1.5), rig), r"2 s or more expected, 1\.5 s found"),
    "low rate": (lambda rig: assemble(circle(), rig, cycles=1, rate=5.0), "10 Hz expected"),
    "no cycle": (lambda rig: assemble(circle(), rig, cycles=0), "at least one cycle"),
    "unknown name": (
        lambda rig: load("fig6", rig),
        "unknown trajectory 'fig6'; did you mean fig5b. expected excitation, fig5a, fig5b, or the path",
    ),
    "too many samples": (lambda rig: load("fig5a", rig, cycles=99_999_999), "at most 10,000,000 samples"),
    "other number of joints": (
        lambda rig: assemble(PAIR.motion("pair"), rig),
        "a motion of 3 joints expected, one of 2 found",
    ),
    "platform without a delta robot": (
        lambda rig: assemble(circle(), BENCH),
        "a motion of joints expected for axes, one of a platform found; ident design --rig FILE makes one",
    ),
    "unknown position": (
        lambda rig: approach(np.array([0, np.nan, 0]), np.zeros(3), rig.limits, 500.0),
        "finite joint angles expected",
    ),
    "no such joint": (lambda rig: multisine(rig, 4, 0.01), "1 to 3 expected, 4 found"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_impossible_motion_is_refused(name: str, rig: Rig) -> None:
    plan, reason = REFUSED[name]
    with pytest.raises(BadInput, match=reason):
        plan(rig)


@pytest.mark.parametrize(("space", "joints"), [("platform", 2), ("platform", 4), ("joint", 0)])
def test_series_with_wrong_number_of_axes_is_refused(space: Literal["platform", "joint"], joints: int) -> None:
    axes = ((0.1,),) * joints
    with pytest.raises(ValueError, match="in each expected"):
        FourierSeries(kind="fourier", space=space, period=2.0, centre=(0.0,) * joints, cosine=axes, sine=axes)

"""Quality of motions, and the search for the best one."""

import numpy as np
import pytest

from ident.design.motions import repeated_motion
from ident.design.problem import Criterion, DesignProblem
from ident.design.quality import motion_quality
from ident.design.search import MARGIN, search
from ident.dynamics import mechanisms
from recordings.errors import BadInput
from recordings.rig import Axis, Limits, Rig, simulated_rig
from trajectories import Trajectory, load
from trajectories.checks import check
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble

RIG = Rig(name="bench", mechanism="axes", axes=(Axis(),), limits=Limits(joint_min=-2.0, joint_max=2.0))


def wave(*sines: float) -> Trajectory:
    series = FourierSeries(
        kind="fourier", space="joint", period=2.0, centre=(0.0,), cosine=((0.0,) * len(sines),), sine=(sines,)
    )
    return assemble(series.motion("wave"), RIG)


def test_standard_errors_agree_with_many_fits() -> None:
    trajectory, rng = wave(0.5, 0.3), np.random.default_rng(0)
    quality = motion_quality(trajectory, RIG, mechanisms.create(RIG), noise=0.2, bandwidth=np.inf)
    rows = mechanisms.create(RIG).regressor(repeated_motion(trajectory))[:, 0]
    fits = np.linalg.lstsq(rows, rng.normal(0, 0.2, (len(rows), 400)), rcond=None)[0]
    np.testing.assert_allclose(quality.std, fits.std(axis=1), rtol=0.15)


def test_band_limited_noise_has_fewer_independent_samples() -> None:
    narrow, wide = (motion_quality(wave(0.5, 0.3), RIG, mechanisms.create(RIG), 0.1, hz) for hz in (25.0, 250.0))
    np.testing.assert_allclose(narrow.std, wide.std * np.sqrt(10))


def test_parameters_that_are_not_excited_have_infinite_standard_errors() -> None:
    rig = RIG.model_copy(update={"axes": (Axis(gravity=True),)})
    quality = motion_quality(wave(1e-7), rig, mechanisms.create(rig), 0.1, 30.0)
    assert np.isinf(quality.std).any()
    assert quality.condition > 1e3


def test_usage_is_relative_to_the_limits() -> None:
    quality = motion_quality(wave(1.0), RIG, mechanisms.create(RIG), 0.1, 30.0)
    assert quality.usage["joint_min or joint_max"] == pytest.approx(0.5, rel=1e-3)
    assert quality.usage["speed"] == pytest.approx(np.pi / RIG.limits.speed, rel=1e-3)


BENCH = Rig(
    name="bench",
    mechanism="axes",
    axes=(Axis(), Axis(type="prismatic")),
    limits=Limits(joint_min=-0.5, joint_max=0.9, speed=3.0, acceleration=25.0),
)


def designed(rig: Rig, criterion: Criterion, harmonics: int = 3, seed: int = 0) -> FourierSeries:
    mechanism = mechanisms.create(rig)
    return search(rig, mechanism, criterion, 4.0, harmonics, np.random.default_rng(seed), lambda *_: None)


@pytest.mark.parametrize("rig", [BENCH, simulated_rig()], ids=["axes", "delta"])
@pytest.mark.parametrize("criterion", ["d", "e"])
def test_slopes_are_derivatives_of_the_objective_and_the_limits(rig: Rig, criterion: Criterion) -> None:
    mechanism = mechanisms.create(rig)
    problem = DesignProblem(rig, mechanism, criterion, 4.0, 2, np.ones(len(mechanism.parameters)))
    rng = np.random.default_rng(1)
    point = np.concatenate([np.full(rig.dof, 0.1), 0.1 * rng.normal(size=4 * rig.dof)])
    direction = rng.normal(size=len(point))
    before, after = (problem.evaluate((point + step * direction)[None]) for step in (-1e-5, 1e-5))
    for slope, low, high in zip(problem.slopes(point), before, after, strict=True):
        np.testing.assert_allclose(slope @ direction, (high - low)[0] / 2e-5, rtol=2e-2, atol=2e-2)


@pytest.mark.parametrize("criterion", ["d", "e"])
def test_the_design_stays_within_the_limits_and_uses_them(criterion: Criterion) -> None:
    trajectory = assemble(designed(BENCH, criterion).motion("best"), BENCH)
    check(trajectory, BENCH)
    used = motion_quality(trajectory, BENCH, mechanisms.create(BENCH), 0.1, 30.0).usage
    assert 0.9 * MARGIN < max(used.values()) <= MARGIN + 1e-6


def test_each_design_is_best_by_its_own_criterion() -> None:
    mechanism = mechanisms.create(BENCH)
    problems = {c: DesignProblem(BENCH, mechanism, c, 4.0, 3, np.ones(6)) for c in ("d", "e")}
    value = {
        (evaluated, optimised): problems[evaluated].evaluate(coefficients(designed(BENCH, optimised))[None])[0][0]
        for evaluated in ("d", "e")
        for optimised in ("d", "e")
    }
    assert value["d", "d"] < value["d", "e"]
    # The search scales columns to their size at the start, so its weights differ slightly from those here.
    assert value["e", "e"] < value["e", "d"] + 0.2


def coefficients(series: FourierSeries) -> np.ndarray:
    return np.concatenate([series.centre, np.ravel(series.cosine), np.ravel(series.sine)])


def test_the_same_seed_gives_the_same_motion() -> None:
    first, again, other = (designed(BENCH, "d", 2, seed) for seed in (0, 0, 1))
    assert first == again != other


def test_limits_without_room_are_refused() -> None:
    tight = simulated_rig().model_copy(update={"limits": Limits(joint_min=-1.2, joint_max=-1.1)})
    with pytest.raises(BadInput, match="leave room to move"):
        designed(tight, "d")


@pytest.mark.slow
def test_a_delta_robot_is_excited_better_than_by_the_built_in_motion() -> None:
    rig = simulated_rig()
    mechanism = mechanisms.create(rig)
    best = motion_quality(assemble(designed(rig, "e", 5).motion("best"), rig), rig, mechanism, 0.1, 30.0)
    built_in = motion_quality(load("excitation", rig), rig, mechanism, 0.1, 30.0)
    assert best.condition < built_in.condition
    assert (best.std < built_in.std).all()

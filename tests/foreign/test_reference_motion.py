"""Reference motions of the second plant."""

import numpy as np
import pytest

from recordings.rig import Geometry
from tests.foreign import reference_motion
from tests.foreign.reference_motion import ReferenceMotion, Shape
from trajectories import kinematics


@pytest.fixture(params=["fourier", "stations"])
def motion(request: pytest.FixtureRequest) -> ReferenceMotion:
    shape: Shape = request.param
    return reference_motion.draw(Geometry(), shape, np.random.default_rng(1), rate=500.0, seconds=12.0)


def test_speed_and_acceleration_are_derivatives_of_the_angle(motion: ReferenceMotion) -> None:
    theta, rate, acceleration = (signal[motion.rows] for signal in (motion.theta, motion.rate, motion.acceleration))
    inner = slice(1, -1)
    by_differences = np.gradient(theta, motion.step, axis=0)
    np.testing.assert_allclose(by_differences[inner], rate[inner], atol=2e-4)
    np.testing.assert_allclose(np.gradient(rate, motion.step, axis=0)[inner], acceleration[inner], atol=0.05)


def test_motion_begins_and_ends_at_rest_with_identical_cycles(motion: ReferenceMotion) -> None:
    rate, cycles = motion.rate[motion.rows], motion.repeat.max() + 1
    assert not rate[[0, -1]].any()
    assert cycles >= 3
    cycle_angles = [motion.theta[motion.rows][motion.repeat == cycle] for cycle in range(cycles)]
    for angles in cycle_angles[1:]:
        np.testing.assert_array_equal(angles, cycle_angles[0])


def test_platform_position_agrees_with_the_forward_kinematics(motion: ReferenceMotion) -> None:
    np.testing.assert_allclose(kinematics.forward(Geometry(), motion.theta), motion.platform, atol=1e-9)


def test_cycle_is_a_whole_number_of_samples(motion: ReferenceMotion) -> None:
    assert (motion.repeat == 0).sum() % motion.per_sample == 0
    assert np.argmax(motion.repeat == 0) % motion.per_sample == 0


@pytest.mark.parametrize("shape", ["fourier", "stations"])
def test_motion_without_repetition_is_one_long_cycle_in_the_same_workspace(shape: Shape) -> None:
    def draw(repeats: bool) -> ReferenceMotion:
        rng = np.random.default_rng(1)
        return reference_motion.draw(Geometry(), shape, rng, rate=250.0, seconds=12.0, repeats=repeats)

    long, cyclic = draw(False), draw(True)
    assert long.repeat.max() == 0
    assert long.time[long.repeat == 0].size * long.step == pytest.approx(12.0, rel=0.5)
    assert np.ptp(long.theta, axis=0).mean() == pytest.approx(np.ptp(cyclic.theta, axis=0).mean(), rel=0.5)
    # The pose after the time of a usual cycle is far from the one before.
    period = (cyclic.repeat == 0).sum()
    theta = long.theta[long.rows][long.repeat == 0]
    assert np.std(theta[period:] - theta[:-period]) > 0.5 * np.std(theta)

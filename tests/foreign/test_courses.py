"""The motions that the second plant prescribes."""

import numpy as np
import pytest

from recordings.rig import Geometry
from tests.foreign import courses
from tests.foreign.courses import ReferenceMotion, Shape
from trajectories import kinematics


@pytest.fixture(params=["fourier", "stations"])
def course(request: pytest.FixtureRequest) -> ReferenceMotion:
    shape: Shape = request.param
    return courses.draw(Geometry(), shape, np.random.default_rng(1), rate=500.0, seconds=12.0)


def test_speed_and_acceleration_are_the_derivatives_of_the_angle(course: ReferenceMotion) -> None:
    theta, rate, acceleration = (signal[course.rows] for signal in (course.theta, course.rate, course.acceleration))
    inner = slice(1, -1)
    by_differences = np.gradient(theta, course.step, axis=0)
    np.testing.assert_allclose(by_differences[inner], rate[inner], atol=2e-4)
    np.testing.assert_allclose(np.gradient(rate, course.step, axis=0)[inner], acceleration[inner], atol=0.05)


def test_it_begins_and_ends_at_rest_and_the_cycles_are_the_same(course: ReferenceMotion) -> None:
    rate, cycles = course.rate[course.rows], course.repeat.max() + 1
    assert not rate[[0, -1]].any()
    assert cycles >= 3
    by_cycle = [course.theta[course.rows][course.repeat == cycle] for cycle in range(cycles)]
    for repetition in by_cycle[1:]:
        np.testing.assert_array_equal(repetition, by_cycle[0])


def test_the_platform_is_where_the_joints_put_it(course: ReferenceMotion) -> None:
    np.testing.assert_allclose(kinematics.forward(Geometry(), course.theta), course.platform, atol=1e-9)


def test_a_cycle_is_a_whole_number_of_samples(course: ReferenceMotion) -> None:
    assert (course.repeat == 0).sum() % course.per_sample == 0
    assert np.argmax(course.repeat == 0) % course.per_sample == 0

"""Reference motions of the second plant."""

import numpy as np
import pytest

from recordings.rig import Geometry
from tests.foreign import reference_motion
from tests.foreign.reference_motion import ReferenceMotion, Shape


@pytest.fixture(params=["fourier", "stations"])
def motion(request: pytest.FixtureRequest) -> ReferenceMotion:
    shape: Shape = request.param
    return reference_motion.draw(Geometry(), shape, np.random.default_rng(1), rate=500.0, seconds=12.0)


def test_motion_begins_and_ends_at_rest_with_identical_cycles(motion: ReferenceMotion) -> None:
    rate, cycles = motion.rate[motion.rows], motion.repeat.max() + 1
    assert not rate[[0, -1]].any()
    assert cycles >= 3
    cycle_angles = [motion.theta[motion.rows][motion.repeat == cycle] for cycle in range(cycles)]
    for angles in cycle_angles[1:]:
        np.testing.assert_array_equal(angles, cycle_angles[0])


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

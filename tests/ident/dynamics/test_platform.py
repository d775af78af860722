"""The platform's motion from the compiled kernel."""

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from ident.dynamics.platform import platform
from recordings.rig import Geometry
from trajectories import kinematics

GEOMETRY = Geometry()


def some_motion() -> Motion:
    rng = np.random.default_rng(1)
    position = rng.uniform(-0.5, 0.3, (50, 3))
    velocity, acceleration = rng.normal(size=(2, 50, 3))
    return Motion(position, velocity, acceleration, np.sign(velocity))


def test_it_is_that_of_the_kinematics_where_it_is_known() -> None:
    motion = some_motion()
    motion.position[7, 1] = motion.velocity[8, 2] = motion.acceleration[9, 0] = np.nan
    result = platform(GEOMETRY, motion)
    expected = kinematics.platform_motion(GEOMETRY, motion.position, motion.velocity, motion.acceleration)
    for actual, signal in zip(
        (result.position, result.velocity, result.acceleration, result.jacobian), expected, strict=True
    ):
        np.testing.assert_allclose(actual, signal, rtol=1e-9, atol=1e-12)


def test_a_mechanism_that_does_not_close_is_refused_with_its_row() -> None:
    motion = some_motion()
    motion.position[5] = [0.82, -1.38, -2.75]
    with pytest.raises(kinematics.Unreachable, match="row 5"):
        platform(Geometry(L2=0.5), motion)

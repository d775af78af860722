"""Payloads of the benchmark of several set-ups."""

import numpy as np
import pytest

pytest.importorskip("pinocchio")

from benchmarks.set_ups import Case, Lift, SwingingAxis, motion_of
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion


@pytest.mark.parametrize(("number", "axis"), [(0, SwingingAxis), (0, Lift), (1, Lift)])
def test_a_payload_is_what_its_rig_file_says(number: int, axis: type[SwingingAxis | Lift]) -> None:
    robot = Case.drawn(number, axis).robot
    way = motion_of(robot, np.random.default_rng(1), 2.0)
    motion = Motion(way.position, way.velocity, way.acceleration, np.sign(way.velocity))
    expected = 2.0 * mechanisms.create(robot.rig(None)).torque_per_mass(motion, robot.place)
    np.testing.assert_allclose(robot.rigid(way, 2.0) - robot.rigid(way, 0.0), expected, rtol=1e-6, atol=1e-6)

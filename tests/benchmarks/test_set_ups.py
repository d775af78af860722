"""Payloads of the benchmark of several set-ups."""

import numpy as np
import pytest

pytest.importorskip("pinocchio")

from benchmarks.drawn_arm import Way
from benchmarks.set_ups import Case
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion


@pytest.mark.parametrize("number", [0, 1])
def test_a_payload_is_what_its_rig_file_says(number: int) -> None:
    robot = Case.drawn(number).robot
    whole = Way.drawn(np.random.default_rng(1), 2.0)
    position, velocity, acceleration = (
        each[:, : robot.joints] for each in (whole.position, whole.velocity, whole.acceleration)
    )
    way, motion = (
        Way(whole.time, position, velocity, acceleration),
        Motion(position, velocity, acceleration, np.sign(velocity)),
    )
    expected = 2.0 * mechanisms.create(robot.rig(None)).torque_per_mass(motion, robot.place)
    np.testing.assert_allclose(robot.rigid(way, 2.0) - robot.rigid(way, 0.0), expected, rtol=1e-6, atol=1e-6)

"""The platform from the compiled kernel, and the torque of a voltage."""

from typing import Literal

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from ident.dynamics.platform import platform
from ident.dynamics.torque_map import torque_from_voltage, torque_per_volt
from recordings.rig import Geometry, Torque
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
    _, P_dot, P_ddot, J = expected
    held = np.einsum("nji,nj->ni", J, P_ddot - kinematics.GRAVITY)
    for actual, signal in ((result.velocity, P_dot), (result.jacobian, J), (result.torque_per_mass, held)):
        np.testing.assert_allclose(actual, signal, rtol=1e-9, atol=1e-12)


def test_a_mechanism_that_does_not_close_is_refused_with_its_row() -> None:
    motion = some_motion()
    motion.position[5] = [0.82, -1.38, -2.75]
    with pytest.raises(kinematics.Unreachable, match="row 5"):
        platform(Geometry(L2=0.5), motion)


VOLTAGE = np.array([[2.0, -3.0, np.nan]])


@pytest.mark.parametrize(("kind", "expected"), [("square", [4.0, -18.0, np.nan]), ("linear", [2.0, -6.0, np.nan])])
def test_torque_keeps_the_sign_and_its_slope_is_the_derivative(
    kind: Literal["square", "linear"], expected: list[float]
) -> None:
    torque = Torque(map=kind, gain=(1.0, 2.0, 1.0))
    np.testing.assert_array_equal(torque_from_voltage(VOLTAGE, torque), [expected])
    step = 1e-6
    rise = torque_from_voltage(VOLTAGE + step, torque) - torque_from_voltage(VOLTAGE - step, torque)
    np.testing.assert_allclose(torque_per_volt(VOLTAGE, torque), rise / (2 * step), rtol=1e-6)

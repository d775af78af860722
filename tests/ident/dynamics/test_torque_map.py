from typing import Literal

import numpy as np
import pytest

from ident.dynamics.torque_map import torque_from_voltage, torque_per_volt
from recordings.rig import Torque

VOLTAGE = np.array([[2.0, -3.0, np.nan]])


def test_square_keeps_the_sign() -> None:
    torque = torque_from_voltage(VOLTAGE, Torque(gain=(1.0, 2.0, 1.0)))
    np.testing.assert_array_equal(torque, [[4.0, -18.0, np.nan]])


def test_linear_is_proportional() -> None:
    torque = torque_from_voltage(VOLTAGE, Torque(map="linear", gain=(1.0, 2.0, 1.0)))
    np.testing.assert_array_equal(torque, [[2.0, -6.0, np.nan]])


@pytest.mark.parametrize("kind", ["square", "linear"])
def test_torque_per_volt_is_the_derivative(kind: Literal["square", "linear"]) -> None:
    torque = Torque(map=kind, gain=(1.0, 2.0, 1.0))
    step = 1e-6
    rise = torque_from_voltage(VOLTAGE + step, torque) - torque_from_voltage(VOLTAGE - step, torque)
    np.testing.assert_allclose(torque_per_volt(VOLTAGE, torque), rise / (2 * step), rtol=1e-6)

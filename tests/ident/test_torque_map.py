import numpy as np

from ident.torque_map import torque_from_voltage
from recordings.rig import Torque

VOLTAGE = np.array([[2.0, -3.0, np.nan]])


def test_square_keeps_the_sign() -> None:
    torque = torque_from_voltage(VOLTAGE, Torque(gain=(1.0, 2.0, 1.0)))
    np.testing.assert_array_equal(torque, [[4.0, -18.0, np.nan]])


def test_linear_is_proportional() -> None:
    torque = torque_from_voltage(VOLTAGE, Torque(map="linear", gain=(1.0, 2.0, 1.0)))
    np.testing.assert_array_equal(torque, [[2.0, -6.0, np.nan]])

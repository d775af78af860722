"""Torque from the operating voltage."""

import numpy as np

from recordings.recording import Floats
from recordings.rig import Torque


def torque_from_voltage(voltage: Floats, torque: Torque) -> Floats:
    """Torque (n, dof) [N m] from the signed operating voltage (n, dof) [V].

    "square" is the paper's tau ~ v^2 (Section 2) with the sign that the square loses: gain v |v|; "linear" is gain v.
    """
    gain = np.array(torque.gain)
    return gain * voltage * np.abs(voltage) if torque.map == "square" else gain * voltage


def torque_per_volt(voltage: Floats, torque: Torque) -> Floats:
    """How far the torque moves per volt (n, dof) [N m/V]: the derivative of `torque_from_voltage`."""
    gain = np.array(torque.gain)
    slope: Floats = 2 * gain * np.abs(voltage) if torque.map == "square" else gain + 0.0 * voltage
    return slope

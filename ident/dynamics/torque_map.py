"""Torque map: torque from operating voltage, and back."""

import numpy as np

from recordings.recording import Floats
from recordings.rig import Rig, Torque


def torque_from_voltage(voltage: Floats, torque_map: Torque) -> Floats:
    """Compute the torque (n, dof) [N m] from the signed operating voltage (n, dof) [V].

    "square" is the paper's tau ~ v^2 (Section 2) with the sign of v: gain v |v|; "linear" is gain v.
    """
    gain = np.array(torque_map.gain)
    return gain * voltage * np.abs(voltage) if torque_map.map == "square" else gain * voltage


def torque_per_volt(voltage: Floats, torque_map: Torque) -> Floats:
    """Compute the derivative (n, dof) [N m/V] of `torque_from_voltage`."""
    gain = np.array(torque_map.gain)
    return 2 * gain * np.abs(voltage) if torque_map.map == "square" else gain + 0.0 * voltage


def voltage_from_torque(torque: Floats, torque_map: Torque) -> Floats:
    """Compute the signed operating voltage (n, dof) [V] that gives the torque (n, dof) [N m]."""
    linear = torque / np.array(torque_map.gain)
    return np.sign(linear) * np.sqrt(np.abs(linear)) if torque_map.map == "square" else linear


def amplifier_unobservable(rig: Rig, torque_measured: bool) -> str | None:
    """Return why a recording of `rig` cannot show effects between command and motor voltage, or None."""
    if torque_measured:
        return "The torque itself, or the motor's current, was recorded, and no command."
    if rig.drives and all(drive.voltage.kind == "motor" for drive in rig.drives):
        return "The reported voltage is the motor's, behind the amplifier; a reported command would show it."
    return None

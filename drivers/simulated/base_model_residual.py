"""Residual of a least-squares fit of the base model with `rod_inertia`.

The regressor is written independently of `ident`: the two share only the kinematics.
"""

from dataclasses import dataclass

import numpy as np

from drivers.simulated.model_xml import GRAVITY
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

BANDWIDTH = 30.0
"""Bandwidth of the analysis: -3 dB, zero-phase [Hz]."""
_ORDER = 2


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Motor positions, their derivatives and torques: n samples, evenly spaced, without noise."""

    position: Floats
    """(n, 3) [rad]."""
    velocity: Floats
    """(n, 3) [rad/s]."""
    acceleration: Floats
    """(n, 3) [rad/s^2]."""
    torque: Floats
    """(n, 3) torque of the reported voltages [N m]."""


@dataclass(frozen=True, eq=False)
class BaseModelResidual:
    """Low-passed samples of the fit: (m, 3) each."""

    residual: Floats
    """Residual of the fit [N m]."""
    torque: Floats
    """[N m]."""
    acceleration: Floats
    """[rad/s^2]."""


def base_model_residual(
    geometry: Geometry, motion: JointMotion, dt: float, window: slice, decimation: int
) -> BaseModelResidual:
    """Fit the base model to `motion`, sampled with `dt` [s]; torque and regressor pass the same low-pass filter.

    `window` selects the samples; every `decimation`-th of them is fitted.
    """
    y: Floats = _low_passed(motion.torque, 1 / dt)[window][::decimation]
    X: Floats = _low_passed(base_columns(geometry, motion), 1 / dt)[window][::decimation]
    matrix = X.reshape(-1, X.shape[2])
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, y.ravel(), rcond=None)[0]
    residual = y - (matrix / scale @ solution).reshape(y.shape)
    joint = np.arange(3)
    return BaseModelResidual(residual=residual, torque=y, acceleration=X[:, joint, joint])


def base_columns(geometry: Geometry, motion: JointMotion) -> Floats:
    """Regressor (n, 3, 12): torque per unit of I_1..3, T_g, m_p, c_v1..3, c_c1..3 and m_d (`rod_inertia`)."""
    theta, rate, acceleration = motion.position, motion.velocity, motion.acceleration
    _, _, P_ddot, J = kinematics.platform_motion(geometry, theta, rate, acceleration)
    lifted = P_ddot + np.array([0.0, 0.0, GRAVITY])
    columns = np.zeros((len(theta), 3, 12))
    joint = np.arange(3)
    columns[:, joint, joint] = acceleration
    columns[:, :, 3] = np.cos(theta)
    columns[:, :, 4] = _times_transposed(J, lifted)
    columns[:, joint, 5 + joint] = rate
    columns[:, joint, 8 + joint] = np.sign(rate)
    columns[:, :, 11] = _rod_inertia(geometry, motion, J, P_ddot)
    return columns


def _rod_inertia(geometry: Geometry, motion: JointMotion, J: Floats, P_ddot: Floats) -> Floats:
    """(n, 3) torque per unit mass of a uniform rod, minus that of the same mass in two halves at its ends.

    The kinetic energy of a uniform rod is m (b.b + b.c + c.c) / 6 in the velocities b and c of its ends, that of the
    halves m (b.b + c.c) / 4.
    """
    theta, rate = motion.position, motion.velocity
    sin, cos = np.sin(theta)[:, :, None], np.cos(theta)[:, :, None]
    outwards = np.stack([np.cos(geometry.phi), np.sin(geometry.phi), np.zeros(3)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    tangent = geometry.L1 * (cos * up - sin * outwards)
    inwards = -geometry.L1 * (cos * outwards + sin * up)
    elbow = tangent * motion.acceleration[:, :, None] + inwards * rate[:, :, None] ** 2
    relative = P_ddot[:, None, :] - elbow
    return np.einsum("nij,nij->ni", tangent, relative) / 6 - _times_transposed(J, relative.sum(axis=1)) / 6


def _low_passed(signals: Floats, rate: float) -> Floats:
    from scipy.signal import butter, sosfiltfilt  # takes long to load, and only hidden effects need it

    # Filtered forwards and backwards: one pass attenuates by 1.5 dB at the bandwidth.
    corner = BANDWIDTH / (np.sqrt(2) - 1) ** (1 / (2 * _ORDER))
    return sosfiltfilt(butter(_ORDER, corner, fs=rate, output="sos"), signals, axis=0)


def _times_transposed(J: Floats, v: Floats) -> Floats:
    return np.einsum("nji,nj->ni", J, v)

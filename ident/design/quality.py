"""What can be known from a motion, before it is recorded."""

from dataclasses import dataclass

import numpy as np

from ident.design.rivals import Rivals
from ident.identifiability import identifiability
from ident.mechanisms import Mechanism
from ident.motion import Motion
from ident.signals import mean_sign
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory, checks


@dataclass(frozen=True, eq=False)
class Quality:
    """What can be known from a motion."""

    condition: float
    """Condition number of the regressor, its columns scaled to length one."""
    std: Floats
    """(k,) expected standard errors of the parameters; infinite for one that the motion does not show."""
    told_apart: tuple[float, float] | None
    """Where two effects are to be told apart: share of the torque of each that neither the model nor the other effect
    can imitate, of what the model alone cannot."""
    usage: dict[str, float]
    """Share of each limit that is used, by its name in the rig file."""


def judge(trajectory: Trajectory, rig: Rig, mechanism: Mechanism, noise: float, bandwidth: float) -> Quality:
    """Judge the repeated part of `trajectory`, for white `noise` [N m] RMS of the torque within `bandwidth` [Hz]."""
    repeated = trajectory.repeat >= 0
    position, velocity, acceleration, direction = (
        signal[repeated]
        for signal in (
            trajectory.joint_position,
            trajectory.joint_velocity,
            trajectory.joint_acceleration,
            np.nan_to_num(mean_sign(trajectory.joint_velocity)),
        )
    )
    columns = mechanism.regressor(Motion(position, velocity, acceleration, direction))
    rows = columns.reshape(-1, columns.shape[2])
    found = identifiability(rows.T @ rows, mechanism.parameters)
    # Noise within a bandwidth is as good as independent samples at twice that rate.
    independent = min(1.0, 2 * bandwidth / trajectory.rate)
    shown = np.array([status != "not" for status in found.status])
    variance = np.full(len(shown), np.inf)
    variance[shown] = np.diag(np.linalg.inv(rows[:, shown].T @ rows[:, shown])) * noise**2 / independent
    used = {name: float(values.max()) for name, values in checks.usage(trajectory, rig).items()}
    return Quality(found.condition, np.sqrt(variance), _told_apart(mechanism, rows), used)


def _told_apart(mechanism: Mechanism, rows: Floats) -> tuple[float, float] | None:
    if not isinstance(mechanism, Rivals):
        return None
    size = np.sqrt(np.mean(rows**2, axis=0))
    first, second = mechanism.separation((rows / np.where(size > 0, size, 1.0))[None])[0]
    return float(first), float(second)

"""What can be known from a motion, before it is recorded."""

from dataclasses import dataclass

import numpy as np

from ident.design.discrimination import DiscriminationModel
from ident.design.motions import repeated_motion
from ident.dynamics.mechanisms import Mechanism
from ident.uncertainty.identifiability import identifiability
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
    discriminability: dict[str, float] | None
    """Where effects are to be told apart: RMS [N m] of the torque of each that no rival can imitate, even with the
    model's help, if of what the effect does on a motion of reference the model alone leaves 1 N m."""
    usage: dict[str, float]
    """Share of each limit that is used, by its name in the rig file."""


def motion_quality(trajectory: Trajectory, rig: Rig, mechanism: Mechanism, noise: float, bandwidth: float) -> Quality:
    """Judge the repeated part of `trajectory`, for white `noise` [N m] RMS of the torque within `bandwidth` [Hz]."""
    if isinstance(mechanism, DiscriminationModel):
        mechanism = mechanism.at_rate(trajectory.rate)
    columns = mechanism.regressor(repeated_motion(trajectory))
    rows = columns.reshape(-1, columns.shape[2])
    found = identifiability(rows.T @ rows, mechanism.parameters)
    # Noise within a bandwidth is as good as independent samples at twice that rate.
    independent = min(1.0, 2 * bandwidth / trajectory.rate)
    shown = np.array([status != "not" for status in found.status])
    variance = np.full(len(shown), np.inf)
    variance[shown] = np.diag(np.linalg.inv(rows[:, shown].T @ rows[:, shown])) * noise**2 / independent
    told = mechanism.discriminability(columns) if isinstance(mechanism, DiscriminationModel) else None
    used = {name: float(values.max()) for name, values in checks.usage(trajectory, rig).items()}
    return Quality(found.condition, np.sqrt(variance), told, used)

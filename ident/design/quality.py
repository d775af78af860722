"""Expected quality of an identification with a motion that has not been recorded."""

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
    """Expected accuracy of the parameters, and use of the limits, of a motion."""

    condition: float
    """Condition number of the regressor with columns scaled to unit length."""
    std: Floats
    """(k,) expected standard errors of the parameters; infinite for parameters that are not identifiable."""
    discriminability: dict[str, float] | None
    """RMS [N m] of each effect's torque that neither the model nor the best alternative effect explains; each effect
    is scaled so that the model alone leaves 1 N m unexplained on a reference motion. None without effects to
    discriminate."""
    usage: dict[str, float]
    """Used share of each limit, by its name in the rig file."""


def motion_quality(trajectory: Trajectory, rig: Rig, mechanism: Mechanism, noise: float, bandwidth: float) -> Quality:
    """Evaluate the repeated part of `trajectory`, for white torque `noise` [N m RMS] within `bandwidth` [Hz]."""
    if isinstance(mechanism, DiscriminationModel):
        mechanism = mechanism.at_rate(trajectory.rate)
    columns = mechanism.regressor(repeated_motion(trajectory))
    rows = columns.reshape(-1, columns.shape[2])
    conditioning = identifiability(rows.T @ rows, mechanism.parameters)
    # Noise within a bandwidth is equivalent to independent samples at twice that rate.
    independent = min(1.0, 2 * bandwidth / trajectory.rate)
    identified = np.array([status != "not" for status in conditioning.status])
    variance = np.full(len(identified), np.inf)
    variance[identified] = (
        np.diag(np.linalg.inv(rows[:, identified].T @ rows[:, identified])) * noise**2 / independent
    )
    discriminability = mechanism.discriminability(columns) if isinstance(mechanism, DiscriminationModel) else None
    usage = {name: float(values.max()) for name, values in checks.usage(trajectory, rig).items()}
    return Quality(conditioning.condition, np.sqrt(variance), discriminability, usage)

"""Goodness of fit: agreement of a model's torque with the measured torque, per joint."""

from dataclasses import dataclass

import numpy as np

from recordings.recording import Floats


@dataclass(frozen=True)
class GoodnessOfFit:
    """Measures of agreement, one number per joint."""

    nrmse: tuple[float, ...]
    """Eq. (41) as printed: 1 - RMS error / range of the *model's* torque; 1 is perfect."""
    rms: tuple[float, ...]
    """RMS of the residual [N m]; of a model that was tested, in the rows that are scored, as `r2`."""
    r2: tuple[float, ...]
    """Coefficient of determination: 1 is perfect, 0 is no better than the mean torque."""


def goodness_of_fit(measured: Floats, computed: Floats) -> GoodnessOfFit:
    """Compare the torques `computed` and `measured`, both (m, dof) [N m]; NaN where not known.

    Eq. (41) is minus infinity for a model whose torque does not vary, because its range is zero.
    """
    error = computed - measured
    usable = np.isfinite(error)
    mean_square = np.nanmean(error**2, axis=0)
    known = np.where(usable, measured, np.nan)
    model = np.where(usable, computed, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        nrmse = 1 - np.sqrt(mean_square) / (np.nanmax(model, axis=0) - np.nanmin(model, axis=0))
        r2 = 1 - mean_square / np.nanvar(known, axis=0)
    return GoodnessOfFit(*(tuple(float(value) for value in row) for row in (nrmse, np.sqrt(mean_square), r2)))

"""Physical consistency of parameters: positive masses and inertias, links that are bodies, dissipative friction."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import LEVEL
from ident.dynamics.mechanisms import Parameter, RigidMechanism
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion, inertia_matrix
from ident.uncertainty.fit_warning import FitWarning
from recordings.recording import Floats

_MAX_SAMPLES = 2000
"""Samples of the motion at which the inertia matrix is evaluated."""
_ROUNDING = 1e-12
"""Share of the largest variance below which one is due to rounding."""


@dataclass(frozen=True)
class Coupling:
    """The inertia matrix D of Eq. (27) along a recording."""

    off_diagonal: tuple[tuple[float, ...], ...]
    """RMS of D_ij / sqrt(D_ii D_jj) along the motion: 1 on the diagonal; 0 where joints do not couple,
    and where a joint has no inertia."""
    share: float
    """RMS of the off-diagonal part over that of the whole matrix (Frobenius norms)."""
    positive: bool
    """D is positive definite throughout, as kinetic energy demands."""


def violations(parameters: Sequence[Parameter], values: Floats, intervals: Floats) -> tuple[FitWarning, ...]:
    """Impossible ones of the `values` (k,), given their 95 % `intervals` (k, 2); NaN where there is no interval."""
    result = []
    for parameter, value, highest in zip(parameters, values, intervals[:, 1], strict=True):
        if value < 0 and parameter.physically_positive:
            significant = bool(highest < 0)
            reason = "friction would drive the motion" if parameter.friction else "it must be positive for any body"
            certainty = "" if significant else "; its interval reaches above zero, so this may be chance"
            sentence = f"{parameter.name} = {value:.4g} {parameter.unit} ({parameter.meaning}): {reason}{certainty}"
            result.append(FitWarning(parameter.name, significant, sentence, not parameter.friction))
    return tuple(result)


def no_bodies(mechanism: RigidMechanism, linear: Floats, covariance: Floats) -> FitWarning | None:
    """Say that no bodies have base parameters in the 95 % region of those identified; None where some have.

    linear: (k,) fitted parameters in which the torque is linear; covariance: (k, k) of them, NaN where unknown.
    """
    from scipy.special import chdtri

    if not isinstance(mechanism, Urdf):
        return None
    base = linear[: len(mechanism.base.columns)]
    error = covariance[: len(base), : len(base)]
    known = np.isfinite(np.diagonal(error))
    std = np.sqrt(np.diagonal(error)[known])
    values, vectors = np.linalg.eigh(error[np.ix_(known, known)] / np.outer(std, std))
    root = np.zeros((len(std), len(base)))
    # Directions without any error of their own are those of rounding.
    root[:, known] = (vectors / np.sqrt(np.maximum(values, _ROUNDING * values[-1]))).T / std
    difference = mechanism.base.combination @ mechanism.nearest_bodies(root, root @ base) - base
    if np.sum((root @ difference) ** 2) <= chdtri(len(std), 1 - LEVEL):
        return None
    sentence = (
        "the inertial parameters, and all others in their 95 % region, are those of no bodies: where no effect is "
        "missing, the data or the rig file cannot be right"
    )
    return FitWarning("links", True, sentence, of_bodies=True)


def coupling(torque: Callable[[Motion], Floats], motion: Motion) -> Coupling | None:
    """Coupling of the joints' inertias along `motion`, by the `torque` (n, dof) of a motion; None for one joint."""
    known = np.isfinite(motion.position).all(axis=1)
    position = motion.position[known]
    position = position[:: max(1, len(position) // _MAX_SAMPLES)]
    D = inertia_matrix(torque, position)
    diagonal = np.diagonal(D, axis1=1, axis2=2)
    dof = diagonal.shape[1]
    if dof == 1:
        return None
    positive = bool((np.linalg.eigvalsh((D + D.swapaxes(1, 2)) / 2)[:, 0] > 0).all())
    scale = np.sqrt(np.abs(diagonal[:, :, None] * diagonal[:, None, :]))
    # A fit may leave a joint without inertia.
    relative = np.divide(D, scale, out=np.zeros_like(D), where=scale > 0)
    off = D * (1 - np.eye(dof))
    matrix = np.sqrt(np.mean(relative**2, axis=0))
    rows = tuple(tuple(float(x) for x in row) for row in matrix)
    return Coupling(rows, float(np.sqrt(np.mean(off**2) / np.mean(D**2))), positive)

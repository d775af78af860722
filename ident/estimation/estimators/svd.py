"""Least squares by truncated singular value decomposition on the linear regression model (37)-(40), reference [19].

Singular values below a share of the largest are set to zero, which yields the solution of minimum norm in directions
that the motion does not excite. Columns are first scaled to unit norm, so that units do not matter. The paper prints
neither scaling nor threshold; on fig5a one singular value is clearly smaller than the others, at 2 % of the largest.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.random import Generator

from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.settings import Meaning

FORM = "lagrange14"


@dataclass(frozen=True)
class Settings:
    """Settings of the truncated decomposition."""

    threshold: Annotated[
        float,
        Meaning(
            "smallest singular value that is kept, relative to the largest, for columns of unit norm",
            least=0,
            below=1,
        ),
    ] = 0.05


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Minimise the sum of squared residuals over the kept directions; their number is the rank."""
    norm = np.linalg.norm(problem.regressor, axis=0)
    U, singular, Vt = np.linalg.svd(problem.regressor / norm, full_matrices=False)
    rank = int(np.count_nonzero(singular > settings.threshold * singular[0]))
    parameters = Vt[:rank].T @ (U[:, :rank].T @ problem.torque / singular[:rank]) / norm
    objective = float(np.sum((problem.torque - problem.regressor @ parameters) ** 2))
    progress(1, 1)
    diagnostics = {"rank": rank, "singular_values": (singular / singular[0]).tolist()}
    return Estimate(parameters, objective, np.array([objective]), diagnostics=diagnostics)

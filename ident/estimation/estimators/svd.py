"""Least squares by truncated singular value decomposition on the linear regression model (37)-(40), reference [19].

Singular values below a share of the largest are taken as zero, so what the motion does not tell apart stays at the
smallest parameters that do. Columns are brought to one length first, or their units would decide. The paper prints
neither scaling nor threshold; on fig5a one singular value stands apart from the others, at 2 % of the largest.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation.problem import Estimate, Problem, Progress
from recordings.errors import BadInput

FORM = "lagrange14"


@dataclass(frozen=True)
class Settings:
    """Settings of the truncation."""

    threshold: float = 0.05
    """Smallest singular value that counts, as a share of the largest, of columns of length one."""

    def __post_init__(self) -> None:
        if not 0 <= self.threshold < 1:
            raise BadInput(f"a threshold from 0 to below 1 expected, {self.threshold:g} found; change it")


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Minimise the sum of squared residuals over the directions that count; their number is the rank."""
    length = np.linalg.norm(problem.regressor, axis=0)
    left, singular, right = np.linalg.svd(problem.regressor / length, full_matrices=False)
    rank = int(np.count_nonzero(singular > settings.threshold * singular[0]))
    parameters = right[:rank].T @ (left[:, :rank].T @ problem.torque / singular[:rank]) / length
    objective = float(np.sum((problem.torque - problem.regressor @ parameters) ** 2))
    progress(1, 1)
    diagnostics = {"rank": rank, "singular_values": (singular / singular[0]).tolist()}
    return Estimate(parameters, objective, np.array([objective]), diagnostics=diagnostics)

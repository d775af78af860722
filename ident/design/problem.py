"""Optimisation problem of a design: the variables are coefficients of a Fourier series of every joint.

With the regressor W of a motion and noise of equal size in all samples, W'W is the information matrix. Criterion "d"
maximises its determinant (minimum volume of the confidence ellipsoid), "e" its smallest eigenvalue (best accuracy of
the least known combination); "t" discriminates effects (see `ident.design.discrimination`). Columns are scaled to
their size at the start, so that units have no influence.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.design.discrimination import DiscriminationModel, products
from ident.design.motions import trajectory
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import checks, kinematics
from trajectories.fourier import FourierSeries

Criterion = Literal["d", "e", "t"]

SAMPLES_PER_HARMONIC = 24
"""Samples in one period of the highest harmonic: enough to resolve the peaks."""
SMOOTHING = 0.01
"""Share of the speed limit below which sgn is smoothed, because the search needs derivatives."""
POWER = 4
"""Power of the power mean of the inverses that approximates the minimum, because the search needs derivatives."""
TINY = 1e-12
"""Lower limit of values before inversion or logarithm."""
STEP = 1e-6
"""Step of the finite differences [rad or m]."""
UNREACHABLE = 1e3
"""Value of the objective and of the use of limits if the mechanism does not close."""


@dataclass(frozen=True, eq=False)
class DesignProblem:
    """Objective and limits for vectors of coefficients: centres, all cosines, all sines, joint by joint."""

    rig: Rig
    mechanism: Mechanism
    criterion: Criterion
    period: float
    """[s]"""
    harmonics: int
    scale: Floats
    """(k,) scale of the regressor's columns."""

    def series(self, coefficients: Floats) -> FourierSeries:
        """Return the motion with these `coefficients`."""
        centre, cosine, sine = self._split(coefficients[None])
        return FourierSeries(
            kind="fourier",
            space="joint",
            period=self.period,
            centre=tuple(centre[0].tolist()),
            cosine=tuple(tuple(axis) for axis in cosine[0].tolist()),
            sine=tuple(tuple(axis) for axis in sine[0].tolist()),
            description=self._description(),
        )

    def _description(self) -> str:
        if isinstance(self.mechanism, DiscriminationModel):
            return "discriminates " + ", ".join(f"{first} from {second}" for first, second in self.mechanism.pairs)
        return f"excitation, {self.criterion.upper()}-optimal"

    def usage(self, coefficients: Floats) -> Floats:
        """(b, l) use of each limit of `coefficients` (b, v); UNREACHABLE if the mechanism does not close."""
        try:
            return self._usage(coefficients)
        except kinematics.Unreachable:
            return np.full((len(coefficients), self._limits), UNREACHABLE)

    def evaluate(self, coefficients: Floats) -> tuple[Floats, Floats]:
        """Objective (b,), to be minimised, and use of each limit (b, l), of `coefficients` (b, v)."""
        try:
            return self._objective(self._rows(coefficients) / self.scale), self._usage(coefficients)
        except kinematics.Unreachable:
            return np.full(len(coefficients), UNREACHABLE), self.usage(coefficients)

    def column_sizes(self, coefficients: Floats) -> Floats:
        """(k,) RMS of the regressor's columns at `coefficients` (v,)."""
        return np.sqrt(np.mean(self._rows(coefficients[None])[0] ** 2, axis=0))

    def _rows(self, coefficients: Floats) -> Floats:
        """(b, rows, k) regressor, not scaled."""
        position, velocity, acceleration = self._motions(coefficients)
        direction = np.tanh(velocity / (SMOOTHING * self.rig.limits.speed))
        mechanism = self.mechanism
        if isinstance(mechanism, DiscriminationModel):
            mechanism = mechanism.at_rate(self._samples / self.period)
        columns = mechanism.regressor(Motion(position, velocity, acceleration, direction))
        return columns.reshape(len(coefficients), -1, columns.shape[2])

    def _usage(self, coefficients: Floats) -> Floats:
        """(b, l) use of each limit."""
        candidate = trajectory("candidate", self.rig, self._samples / self.period, *self._motions(coefficients))
        used = np.stack(list(checks.usage(candidate, self.rig).values()), axis=1)
        return used.reshape(len(coefficients), self._samples, -1).max(axis=1)

    def slopes(self, coefficients: Floats) -> tuple[Floats, Floats]:
        """Derivatives of the objective (v,) and of the use of each limit (l, v) at `coefficients` (v,)."""
        steps = np.concatenate([np.zeros((1, len(coefficients))), STEP * np.eye(len(coefficients))])
        objective, used = self.evaluate(coefficients + steps)
        return (objective[1:] - objective[0]) / STEP, (used[1:] - used[0]).T / STEP

    def _objective(self, rows: Floats) -> Floats:
        if isinstance(self.mechanism, DiscriminationModel):
            unexplained = np.concatenate(list(self.mechanism.unexplained(products(rows)).values()), axis=1)
            return _soft_minimum(unexplained)
        information = rows.transpose(0, 2, 1) @ rows / rows.shape[1]
        eigenvalues = np.maximum(np.linalg.eigvalsh(information), TINY)
        if self.criterion == "d":
            objective: Floats = -np.log(eigenvalues).mean(axis=1)
        else:
            objective = _soft_minimum(eigenvalues)
        return objective

    @property
    def _limits(self) -> int:
        return 7 if self.rig.mechanism == "delta" else 3

    @property
    def _samples(self) -> int:
        return SAMPLES_PER_HARMONIC * self.harmonics

    def _split(self, coefficients: Floats) -> tuple[Floats, Floats, Floats]:
        """Centres (b, dof), cosines and sines (b, dof, harmonics)."""
        b, dof = len(coefficients), self.rig.dof
        centre, cosine, sine = np.split(coefficients, [dof, dof * (1 + self.harmonics)], axis=1)
        return centre, cosine.reshape(b, dof, -1), sine.reshape(b, dof, -1)

    def _motions(self, coefficients: Floats) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration (b * samples, dof), one motion after the other."""
        centre, cosine, sine = self._split(coefficients)
        omega = 2 * np.pi / self.period * np.arange(1, self.harmonics + 1)
        angle = np.outer(omega, np.arange(self._samples) * self.period / self._samples)
        cos, sin, w = np.cos(angle), np.sin(angle), omega[:, None]
        curves = (
            centre[:, :, None] + cosine @ cos + sine @ sin,
            sine @ (w * cos) - cosine @ (w * sin),
            -cosine @ (w**2 * cos) - sine @ (w**2 * sin),
        )
        position, velocity, acceleration = (x.transpose(0, 2, 1).reshape(-1, self.rig.dof) for x in curves)
        return position, velocity, acceleration


def _soft_minimum(values: Floats) -> Floats:
    """(b,) minus the logarithm of the approximate minimum of `values` (b, q)."""
    return np.log(np.mean(np.maximum(values, TINY) ** -POWER, axis=1)) / POWER

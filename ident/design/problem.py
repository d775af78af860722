"""The optimisation problem: coefficients of a Fourier series of every joint, how good it is, which limits it uses.

With the regressor W of a motion and noise of equal size in all samples, W'W is the information about the parameters.
"d" maximises its determinant (the volume of the confidence ellipsoid shrinks), "e" its smallest eigenvalue (what is
known worst gets better); "t" tells two effects apart (see `ident.design.discrimination`). Columns are scaled to the
torque that they gave at the start, so that units do not decide.
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
"""In one period of the highest harmonic: enough to see the peaks."""
SMOOTHING = 0.01
"""Share of the limit of speed below which sgn is smoothed, as the search needs slopes."""
POWER = 4
"""The smallest is approached by the mean of this power of all inverse ones, which has slopes."""
TINY = 1e-12
"""What is smaller is none."""
STEP = 1e-6
"""Of differences [rad or m]."""
UNREACHABLE = 1e3
"""Objective, and use of limits, where the mechanism does not close."""


@dataclass(frozen=True, eq=False)
class DesignProblem:
    """What is sought, for vectors of coefficients: centres, then all cosines, then all sines, joint by joint."""

    rig: Rig
    mechanism: Mechanism
    criterion: Criterion
    period: float
    """[s]"""
    harmonics: int
    scale: Floats
    """(k,) of the regressor's columns."""

    def series(self, coefficients: Floats) -> FourierSeries:
        """The motion with these coefficients."""
        centre, cosine, sine = self._parts(coefficients[None])
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
            return "tells " + ", ".join(f"{first} from {second}" for first, second in self.mechanism.pairs)
        return f"excitation, {self.criterion.upper()}-optimal"

    def usage(self, coefficients: Floats) -> Floats:
        """Use of each limit (b, l) of `coefficients` (b, v); FAR where the mechanism does not close."""
        try:
            return self._usage(coefficients)
        except kinematics.Unreachable:
            return np.full((len(coefficients), self._limits), UNREACHABLE)

    def evaluate(self, coefficients: Floats) -> tuple[Floats, Floats]:
        """Objective (b,), the smaller the better, and use of each limit (b, l), of `coefficients` (b, v)."""
        try:
            return self._objective(self._rows(coefficients) / self.scale), self._usage(coefficients)
        except kinematics.Unreachable:
            return np.full(len(coefficients), UNREACHABLE), self.usage(coefficients)

    def column_sizes(self, coefficients: Floats) -> Floats:
        """RMS (k,) of the regressor's columns at `coefficients` (v,)."""
        size: Floats = np.sqrt(np.mean(self._rows(coefficients[None])[0] ** 2, axis=0))
        return size

    def _rows(self, coefficients: Floats) -> Floats:
        """The regressor (b, rows, k), not scaled."""
        position, velocity, acceleration = self._motions(coefficients)
        direction = np.tanh(velocity / (SMOOTHING * self.rig.limits.speed))
        mechanism = self.mechanism
        if isinstance(mechanism, DiscriminationModel):
            mechanism = mechanism.at_rate(self._samples / self.period)
        columns = mechanism.regressor(Motion(position, velocity, acceleration, direction))
        return columns.reshape(len(coefficients), -1, columns.shape[2])

    def _usage(self, coefficients: Floats) -> Floats:
        """(b, l)."""
        candidate = trajectory("candidate", self.rig, self._samples / self.period, *self._motions(coefficients))
        used = np.stack(list(checks.usage(candidate, self.rig).values()), axis=1)
        most: Floats = used.reshape(len(coefficients), self._samples, -1).max(axis=1)
        return most

    def slopes(self, coefficients: Floats) -> tuple[Floats, Floats]:
        """Derivatives of the objective (v,) and of the use of each limit (l, v) at `coefficients` (v,)."""
        steps = np.concatenate([np.zeros((1, len(coefficients))), STEP * np.eye(len(coefficients))])
        objective, used = self.evaluate(coefficients + steps)
        return (objective[1:] - objective[0]) / STEP, (used[1:] - used[0]).T / STEP

    def _objective(self, rows: Floats) -> Floats:
        if isinstance(self.mechanism, DiscriminationModel):
            told = np.concatenate(list(self.mechanism.unexplained(products(rows)).values()), axis=1)
            return _least(told)
        information = rows.transpose(0, 2, 1) @ rows / rows.shape[1]
        eigenvalues = np.maximum(np.linalg.eigvalsh(information), TINY)
        if self.criterion == "d":
            objective: Floats = -np.log(eigenvalues).mean(axis=1)
        else:
            objective = _least(eigenvalues)
        return objective

    @property
    def _limits(self) -> int:
        return 7 if self.rig.mechanism == "delta" else 3

    @property
    def _samples(self) -> int:
        return SAMPLES_PER_HARMONIC * self.harmonics

    def _parts(self, coefficients: Floats) -> tuple[Floats, Floats, Floats]:
        """Centres (b, dof), cosines and sines (b, dof, harmonics)."""
        b, dof = len(coefficients), self.rig.dof
        centre, cosine, sine = np.split(coefficients, [dof, dof * (1 + self.harmonics)], axis=1)
        return centre, cosine.reshape(b, dof, -1), sine.reshape(b, dof, -1)

    def _motions(self, coefficients: Floats) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration (b * samples, dof), one motion after the other."""
        centre, cosine, sine = self._parts(coefficients)
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


def _least(values: Floats) -> Floats:
    """(b,) minus the logarithm of about the smallest of `values` (b, q)."""
    least: Floats = np.log(np.mean(np.maximum(values, TINY) ** -POWER, axis=1)) / POWER
    return least

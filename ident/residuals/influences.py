"""The quantity on which most of a joint's residual depends: a curve over it, or a wave over the joint's position."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.dynamics.effects.learned_curve import hat_functions
from ident.dynamics.effects.periodogram import highest_in_band, periodogram
from ident.identification.prediction import Prediction
from ident.residuals.curves import axis_values
from recordings.recording import Floats

Variable = Literal["velocity", "position", "acceleration", "load", "load rate", "time"]
_OWN: tuple[Variable, ...] = ("velocity", "position", "acceleration", "load", "load rate", "time")
_OF_OTHERS: tuple[Variable, ...] = ("velocity", "position", "acceleration")
_REVERSING: tuple[Variable, ...] = ("position", "load", "time")
_WORDS = {"load": "{} computed load", "load rate": "the rate of change of {} computed load", "time": "the time"}

PIECES = 8
"""Straight pieces of a curve, with the same number of samples each."""
MIN_EXPLAINED = 0.2
"""A smaller share of the squared residual is not spoken of."""
_POINTS = 4
"""Points of a periodogram per resolution cell."""
_NEGLIGIBLE = 1e-9
"""Columns of which less than this share of the square is left by others are combinations of them."""


@dataclass(frozen=True)
class Influence:
    """A quantity on which the residual of one joint depends."""

    variable: Variable
    joint: int
    """Joint of the variable, from 1."""
    reverses: bool
    """Whether the dependence changes its sign with the direction of motion, as friction does."""
    periods: float | None
    """Of a wave over the position: per turn (of a slide: per metre); None: the dependence is a curve."""
    explained: float
    """Share of the squared residual when the mechanism's parameters are refitted with it, 0 to 1."""

    def sentence(self, joint: int, unit: str) -> str:
        """Say on what the residual of `joint` (from 1) depends; `unit` of the periods: turn or metre."""
        owner = "its" if self.joint == joint else f"joint {self.joint}'s"
        quantity = _WORDS.get(self.variable, f"{{}} {self.variable}").format(owner)
        reversing = ", reversed with the direction of motion," if self.reverses else ""
        order = f": {self.periods:.1f} periods per {unit}" if self.periods else ""
        return (
            f"Joint {joint}: a {'wave' if self.periods else 'curve'} over {quantity}{reversing} explains "
            f"{100 * self.explained:.0f} % of the squared residual{order}."
        )


def strongest_influence(predictions: Sequence[Prediction], joint: int) -> Influence:
    """Find the quantity that explains most of the scored residual of a joint (0 to dof - 1) in all `predictions`."""
    residual = np.concatenate([each.scored_residual[:, joint] for each in predictions])
    regressor = np.concatenate([each.prepared.regressor[:, joint] for each in predictions])
    direction = np.concatenate([each.prepared.motion.direction[:, joint] for each in predictions])
    rows = np.isfinite(residual) & np.isfinite(regressor).all(axis=1) & np.isfinite(direction)
    left = _Residual(residual[rows], regressor[rows])
    influences = []
    for of in range(predictions[0].computed.shape[1]):
        for variable in _OWN if of == joint else _OF_OTHERS:
            x = np.nan_to_num(axis_values(variable, predictions, of)[rows])
            columns = hat_functions(x, np.unique(np.quantile(x, np.linspace(0, 1, PIECES + 1))))
            influences.append(Influence(variable, of + 1, False, None, left.explained(columns)))
            if of == joint and variable in _REVERSING:
                share = left.explained(columns * direction[rows, None])
                influences.append(Influence(variable, of + 1, True, None, share))
    position, speed = (axis_values(name, predictions, joint)[rows] for name in ("position", "velocity"))
    bandwidth = min(each.prepared.bandwidth for each in predictions)
    slides = predictions[0].prepared.recording.rig.position_units[joint] == "m"
    influences += left.waves(position, np.abs(speed), bandwidth, joint, 2 * np.pi if slides else 1.0)
    return max(influences, key=lambda influence: influence.explained)


class _Residual:
    """The residual of a joint, in two parts: what the mechanism's parameters could take up, and the rest.

    A wrong parameter is all in the first part, and a missing torque, after a fit, in the second. Of a missing torque,
    the fit has taken up what it could; therefore the second part is compared with what it would leave of a curve.
    """

    def __init__(self, residual: Floats, regressor: Floats) -> None:
        size = np.sqrt((regressor**2).sum(axis=0))
        directions, values, _ = np.linalg.svd(regressor[:, size > 0] / size[size > 0], full_matrices=False)
        self._directions = directions[:, values**2 > _NEGLIGIBLE]
        self._taken_up = self._directions @ (self._directions.T @ residual)
        self._rest = residual - self._taken_up
        self._square = float(residual @ residual)

    def explained(self, columns: Floats) -> float:
        """Share of the squared residual that the best sum of `columns` (m, k) explains."""
        outside = columns - self._directions @ (self._directions.T @ columns)
        squares = _projected_square(columns, self._taken_up) + _projected_square(outside, self._rest)
        return min(squares / self._square, 1.0) if self._square else 0.0

    def waves(
        self, position: Floats, speed: Floats, bandwidth: float, joint: int, per_radian: float
    ) -> Iterator[Influence]:
        """Yield the best wave over the `position` (m,) that is too fine for a curve, and within the `bandwidth` [Hz].

        speed: (m,) not negative [rad/s or m/s]; per_radian: wave number of one period per turn, or per metre.
        """
        from scipy.optimize import minimize_scalar

        if not speed.any() or not np.ptp(position):
            return
        cell = 2 * np.pi / float(np.ptp(position))
        grid = np.arange(PIECES / 4 * cell, highest_in_band(speed, bandwidth), cell / _POINTS)
        if not len(grid):
            return

        def explained(number: float) -> float:
            return self.explained(np.stack([np.sin(number * position), np.cos(number * position)], axis=1))

        peak = float(grid[np.argmax(periodogram(position, self._rest, grid))])
        near = (peak - cell / 2, peak + cell / 2)
        number = float(minimize_scalar(lambda each: -explained(each), bounds=near, method="bounded").x)
        yield Influence("position", joint + 1, False, number / per_radian, explained(number))


def _projected_square(columns: Floats, signal: Floats) -> float:
    """Square of the part of `signal` (m,) that is a sum of `columns` (m, k)."""
    product = columns.T @ signal
    return float(product @ np.linalg.pinv(columns.T @ columns, _NEGLIGIBLE, hermitian=True) @ product)

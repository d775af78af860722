"""Training rows and test rows of recordings, and what is computed from them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.basics.statistics import nonzero
from ident.basics.threads import in_threads
from ident.data.cycle_statistics import repeating_share
from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import with_encoder_errors
from ident.data.row_weights import MAX_STANDSTILL
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import (
    Solution,
    escape_local_minima,
    initial_solution,
    levenberg_marquardt,
    linearized_solution,
)
from ident.estimation.predicted_torque import TorquePredictor
from ident.uncertainty.propagated_errors import perturbed_draws
from recordings.pickling import WithoutCaches
from recordings.recording import Bools, Floats, Ints

TINY = 1e-12
"""Torque [N m] or share that counts as zero: smaller differences are rounding errors."""
MAX_AMPLIFICATION = 2.0
"""Rows that amplify torque errors more than this are not scored."""


@dataclass(frozen=True, eq=False)
class SplitData(WithoutCaches):
    """Prepared recordings with training rows, test rows and unused rows."""

    predictors: tuple[TorquePredictor, ...]
    train: tuple[Bools, ...]
    """(m, dof) training rows of each recording."""
    test: tuple[Bools, ...]
    """(m, dof) test rows of each recording."""
    weights: tuple[Floats, ...]
    """(m, dof) of each recording [1 / (N m)]; 0 outside of the training rows."""
    other_motion: bool
    """Whether the test rows are of other recordings; else they are phase segments of the same ones."""
    standstill_share: float = 0.0
    """Share of the rows that are not used because a joint stands still."""
    unjudged_shares: tuple[float, ...] = ()
    """Share of the test rows of each joint that are not scored as they do not judge the model; empty if all are."""
    train_all: tuple[Bools, ...] = ()
    """(m, dof) training rows of each recording, with those that are not used because a joint stands still, or not
    scored."""
    test_all: tuple[Bools, ...] = ()
    row_weights: tuple[Floats, ...] = ()
    """(m, dof) of each recording [1 / (N m)], whatever the subset of a row."""

    @property
    def recordings(self) -> tuple[PreparedRecording, ...]:
        """The recordings of the predictors."""
        return tuple(predictor.prepared for predictor in self.predictors)

    @property
    def scored(self) -> tuple[Bools, ...]:
        """(m, dof) of each recording: training rows and test rows."""
        return tuple(train | test for train, test in zip(self.train, self.test, strict=True))

    @property
    def floor_rows(self) -> tuple[Bools, ...]:
        """(m, dof) rows that tell the noise floor: those that are scored, or all of a joint of which none is."""
        pairs = zip(self.scored, self.recordings, strict=True)
        return tuple(np.where(rows.any(axis=0), rows, recording.usable) for rows, recording in pairs)

    @cached_property
    def turned(self) -> "SplitData":
        """The same recordings, where training rows and test rows change places."""
        weights = tuple(np.where(rows, weight, 0.0) for rows, weight in zip(self.test, self.row_weights, strict=True))
        return replace(self, train=self.test, test=self.train, weights=weights)

    @cached_property
    def travel(self) -> Floats:
        """(dof,) travel of each joint in the recordings with training rows [rad or m]."""
        positions = np.concatenate([each.prepared.motion.position for each in self.train_predictors])
        return np.nanmax(positions, axis=0) - np.nanmin(positions, axis=0)

    @cached_property
    def perturbed(self) -> tuple[TorquePredictor, ...]:
        """The recordings with perturbed encoder readings: random errors of at most half an encoder step."""
        return tuple(map(TorquePredictor, in_threads(with_encoder_errors, self.recordings)))

    @cached_property
    def perturbed_draws(self) -> tuple[tuple[TorquePredictor, ...], ...]:
        """Several such perturbations of the recordings with training rows."""
        return perturbed_draws([self.predictors[i].prepared for i in self.train_indices])

    @cached_property
    def repeating_share(self) -> tuple[Floats, ...]:
        """(dof,) of each recording: share of the finest part of its motion that is the same in all repetitions."""
        return tuple(repeating_share(predictor.prepared) for predictor in self.predictors)

    def perturbed_regressors(self, bare: ModelStructure) -> tuple[list[tuple[Floats, Floats]], Floats]:
        """Regressors with measured and with perturbed encoder readings, and the attenuation bias between them.

        Returns for each recording both regressors (m, dof, K) of the `bare` structure, and the matrix (K, K) by which
        a fit to the second changes the parameters. Errors in a regressor attenuate the parameters: with coarse
        encoder steps, inertias are underestimated.
        """
        names = tuple(term.name for term in bare.terms)
        if names not in self._perturbed_regressors:
            x = np.zeros(len(bare.parameters))
            measured, perturbed = (
                in_threads(lambda predictor: predictor.linearized(bare, x)[1], predictors)
                for predictors in (self.predictors, self.perturbed)
            )
            pairs = list(zip(measured, perturbed, strict=True))
            self._perturbed_regressors[names] = pairs, self._attenuation_bias(pairs)
        return self._perturbed_regressors[names]

    @cached_property
    def _perturbed_regressors(self) -> dict[tuple[str, ...], tuple[list[tuple[Floats, Floats]], Floats]]:
        """Results of `perturbed_regressors`, by the names of effects."""
        return {}

    def _attenuation_bias(self, pairs: Sequence[tuple[Floats, Floats]]) -> Floats:
        """(K, K) bias in `perturbed_regressors`, by weighted least squares over the training rows."""
        rows, errors = [], []
        for weight, (measured, perturbed) in zip(self.weights, pairs, strict=True):
            known = (weight > 0) & np.isfinite(measured).all(axis=2) & np.isfinite(perturbed).all(axis=2)
            rows.append((perturbed * weight[:, :, None])[known])
            errors.append(((measured - perturbed) * weight[:, :, None])[known])
        size = nonzero(np.sqrt((np.concatenate(rows) ** 2).sum(axis=0)))
        coefficients = np.linalg.lstsq(np.concatenate(rows) / size, np.concatenate(errors), rcond=1e-10)[0]
        return coefficients / size[:, None]

    @cached_property
    def train_indices(self) -> tuple[int, ...]:
        """Indices of the recordings with training rows."""
        return tuple(i for i, rows in enumerate(self.train) if rows.any())

    @cached_property
    def independent_rows(self) -> float:
        """Equivalent number of independent training rows: a low-pass correlates neighbours."""
        return float(self.independent(self.train).sum())

    def independent(self, rows: Sequence[Bools]) -> Floats:
        """(dof,) equivalent number of independent ones among the `rows` (m, dof) of all recordings."""
        return np.sum(
            [
                selected.sum(axis=0) * min(1.0, 2 * data.bandwidth / data.rate)
                for selected, data in zip(rows, self.recordings, strict=True)
            ],
            axis=0,
        )

    @cached_property
    def torque_rms(self) -> Floats:
        """(dof,) RMS of the measured torque over all scored rows [N m]."""
        return rms([recording.torque for recording in self.recordings], self.scored)

    def fit(self, structure: ModelStructure, x: Floats) -> Solution:
        """Fit the model `structure` to the training rows, starting from `x` (K,)."""
        return self.fit_nonlinear(self.fit_linear(structure, x))

    def fit_linear(self, structure: ModelStructure, x: Floats) -> Solution:
        """Fit the linear parameters of `structure` to the training rows, with the others as in `x` (K,)."""
        return initial_solution(self.train_predictors, structure, x, self._train_weights)

    def at(self, structure: ModelStructure, x: Floats) -> Solution:
        """The model `structure` with the parameters `x` (K,), as if they had been fitted."""
        return linearized_solution(self.train_predictors, structure, x, self._train_weights)

    def fit_nonlinear(self, solution: Solution) -> Solution:
        """Fit all parameters, starting from those of a `solution`."""
        return levenberg_marquardt(self.train_predictors, solution, self._train_weights)

    def escape_local_minima(self, solution: Solution) -> Solution:
        """Improve a `solution` that may be a local minimum, if its structure has discontinuous effects."""
        return escape_local_minima(self.train_predictors, solution, self._train_weights)

    @property
    def train_predictors(self) -> list[TorquePredictor]:
        """The predictors of the recordings with training rows."""
        return [self.predictors[i] for i in self.train_indices]

    @property
    def _train_weights(self) -> list[Floats]:
        return [self.weights[i] for i in self.train_indices]

    def unjudged(self, solution: Solution, error: Floats) -> tuple[Bools, ...]:
        """(m, dof) rows of each recording that say nothing for or against a model: in saturation, or extrapolated.

        None of a joint of which hardly any test rows would be left. Fits still use these rows (the weights are
        unchanged): only they show where saturation begins.

        error: (dof,) smallest detectable torque error [N m].
        """
        unknown = self._saturated(solution, error)
        for term in solution.structure.terms:
            unknown = tuple(rows | beyond for rows, beyond in zip(unknown, self.beyond(term), strict=True))
        kept = row_count([test & ~rows for test, rows in zip(self.test, unknown, strict=True)])
        return tuple(rows & (kept >= self.recordings[0].regressor.shape[2]) for rows in unknown)

    def beyond(self, term: Term) -> tuple[Bools, ...]:
        """(m, dof) rows of each recording out of the range of training, where the curve of a `term` is not known."""
        if not term.effect.curve:
            return tuple(np.zeros_like(rows) for rows in self.train)
        velocity = term.effect.axis == "velocity"
        signals = [each.motion.velocity if velocity else each.motion.position for each in self.recordings]
        joints = np.isin(np.arange(signals[0].shape[1]), term.joints)
        return tuple(rows & joints for rows in outside_of_range(signals, *training_range(signals, self.train)))

    def _saturated(self, solution: Solution, error: Floats) -> tuple[Bools, ...]:
        """(m, dof) rows of each recording in which the reported signal hardly depends on the torque."""
        structure, x = solution.structure, solution.x
        if not any(term.effect.distorts_report for term in structure.terms):
            return tuple(np.zeros_like(rows) for rows in self.train)
        amplification = [predictor.error_amplification(structure, x, error) for predictor in self.predictors]
        return tuple(
            data.condition(np.where(np.isfinite(size), size > MAX_AMPLIFICATION, np.nan).astype(float))
            > MAX_STANDSTILL
            for data, size in zip(self.recordings, amplification, strict=True)
        )

    def judged(self, solution: Solution, error: Floats) -> "SplitData":
        """Score only the rows that a model can be judged by; `error` as in `unjudged`."""
        unjudged = self.unjudged(solution, error)
        if not any((rows & scored).any() for rows, scored in zip(unjudged, self.scored, strict=True)):
            return self
        train, test = (
            tuple(rows & ~unknown for rows, unknown in zip(subset, unjudged, strict=True))
            for subset in (self.train, self.test)
        )
        shares = 1 - row_count(test) / np.maximum(row_count(self.test), 1)
        return replace(self, train=train, test=test, unjudged_shares=tuple(shares.tolist()))

    def residuals(self, solution: Solution) -> tuple[Floats, ...]:
        """(m, dof) measured minus computed torque of every recording [N m]."""
        structure, x = solution.structure, solution.x
        return tuple(
            in_threads(lambda predictor: predictor.prepared.torque - predictor.torque(structure, x), self.predictors)
        )


def row_count(rows: Sequence[Bools]) -> Ints:
    """(dof,) number of `rows` (m, dof) of all recordings."""
    return np.sum([selected.sum(axis=0) for selected in rows], axis=0)


def rms(residuals: Sequence[Floats], selected: Sequence[Bools]) -> Floats:
    """(dof,) RMS of the `selected` rows (m, dof) of all recordings; NaN is skipped."""
    known = [rows & np.isfinite(residual) for residual, rows in zip(residuals, selected, strict=True)]
    squares = sum(
        np.where(rows, residual**2, 0.0).sum(axis=0) for residual, rows in zip(residuals, known, strict=True)
    )
    return np.sqrt(squares / np.maximum(row_count(known), 1))


def training_range(signals: Sequence[Floats], train: Sequence[Bools]) -> tuple[Floats, Floats]:
    """Smallest and largest value (dof,) of the `signals` (m, dof) of all recordings in the `train` rows (m, dof).

    NaN where a joint has no training rows.
    """
    trained = np.concatenate([np.where(rows, signal, np.nan) for rows, signal in zip(train, signals, strict=True)])
    return np.fmin.reduce(trained), np.fmax.reduce(trained)


def outside_of_range(signals: Sequence[Floats], low: Floats, high: Floats) -> tuple[Bools, ...]:
    """(m, dof) rows of each recording at which the `signals` (m, dof) are below `low` or above `high` (dof,)."""
    return tuple((signal < low) | (signal > high) for signal in signals)

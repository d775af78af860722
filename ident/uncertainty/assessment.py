"""Assessment of a fit: all that is known about its errors, as stored in the model file."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import Literal

import numpy as np

from ident.basics.statistics import LEVEL
from ident.data import cycle_statistics, noise
from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import holds_torque
from ident.data.trends import Trend
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure
from ident.estimation import chunks, estimators
from ident.estimation.linear_fit import Fit
from ident.estimation.regression import Regression
from ident.uncertainty import covariance, physical_consistency, sensitivity
from ident.uncertainty.covariance import IntervalMethod, Uncertainty
from ident.uncertainty.fit_warning import FitWarning
from ident.uncertainty.identifiability import Combination, Status, identifiability
from ident.uncertainty.physical_consistency import Coupling
from ident.uncertainty.propagated_errors import independent, propagated_variance
from recordings.config import ConfigSection
from recordings.recording import Bools, Floats, Recording

OptionalFloat = float | None
Loss = Literal["absolute deviations", "squares", "weighted squares"]


class ParameterUncertainty(ConfigSection):
    """Uncertainty of one parameter, in its unit; None if the data do not determine it (at a bound, inseparable)."""

    std: OptionalFloat = None
    """Standard error due to noise alone."""
    ci95: tuple[float, float] | None = None
    """95 % confidence interval; with the gain's uncertainty if the parameter is absolute, see `Assessment`."""
    shape_ci95: tuple[float, float] | None = None
    """The same for an exactly known gain, whose error all torques share: ratios of parameters have none of it."""
    degrees_of_freedom: OptionalFloat = None
    """Of the standard error; None where they are infinite."""
    status: Status | None = None
    """Whether the motion distinguishes this parameter from the others."""
    per_length_step: OptionalFloat = None
    """Change if the rods are 10 mm longer."""
    per_cutoff: tuple[float, ...] = ()
    """Change at each of `Assessment.cutoffs`."""


class JointNoise(ConfigSection):
    """Noise of one joint in the analysis band."""

    volts: float
    """Standard deviation of the measured drive signal, in `unit`."""
    unit: str
    """V, or the unit of the effort if that was measured."""
    floor: float
    """Standard deviation of the torque at zero voltage [N m]."""
    source: Literal["repetition", "band above the signal"]


class JointFloor(ConfigSection):
    """Mean square of one joint's residual [(N m)^2], split into noise and the part that repeats with the motion."""

    cycles: int
    noise_rms: float
    """Noise floor [N m]."""
    total: float
    noise: float
    repeating: float
    repeating_p: float
    above_noise: float
    """Share of the mean square that is not noise."""
    trend: Trend | None
    """None if not significant."""


class Assessment(ConfigSection):
    """Errors of a fit and their causes."""

    level: float = LEVEL
    source: IntervalMethod
    """Estimator of the noise's autocovariance, see `ident.uncertainty.covariance`."""
    loss: Loss
    """Objective of the estimator that the intervals belong to."""
    absolute: bool
    """True if the intervals are of absolute values and include the gain's uncertainty; else they are of ratios."""
    gain_uncertainty: float
    """Relative standard uncertainty that the intervals include."""
    scale_uncertainty: float = 0.0
    """Relative standard uncertainty of the gain, whether or not the intervals include it; 0 for measured torque."""
    correlation: tuple[tuple[OptionalFloat, ...], ...]
    """Correlation matrix of the errors: of the linear parameters, then of those found by a search, where known."""
    condition_number: float
    singular_values: tuple[float, ...]
    inseparable: tuple[Combination, ...]
    noise: tuple[JointNoise, ...]
    floor: tuple[JointFloor, ...] | None
    """None where the motion is not repeated."""
    warnings: tuple[FitWarning, ...]
    """What speaks against the model, or limits what its values are worth."""
    coupling: Coupling | None
    cutoffs: tuple[float, ...]
    """Other cut-offs for which the fit was repeated [Hz]."""


def assess(
    regressions: Sequence[Regression],
    fit: Fit,
    structure: ModelStructure,
    method: str,
    parameter_changes: sensitivity.Sensitivity,
    relative: bool,
    interval_method: IntervalMethod = "stationary",
    x: Floats | None = None,
) -> tuple[Assessment, tuple[ParameterUncertainty, ...]]:
    """Assess the `fit` of `structure` by the estimator `method`: as a whole, and parameter by parameter.

    Given `x`, all parameters are assessed together, those found by a search behind the linear ones.

    parameter_changes: changes of the parameters under other assumptions.
    relative: the parameters are known up to one common factor.
    x: (K,) all parameters, for intervals that hold what quantization does to them too; None: noise alone.
    """
    prepared = [regression.prepared for regression in regressions]
    residuals = [regression.residual(fit.parameters) for regression in regressions]
    joint_noise = noise.estimate(prepared, residuals)
    loss = loss_of(fit, method)
    conditioning = identifiability(_gram(regressions), structure.linear_parameters)
    free = np.array([s != "not" and not b for s, b in zip(conditioning.status, fit.at_bound, strict=True)])
    order, values = np.flatnonzero(structure.linear), fit.parameters
    if x is not None and structure.searched.any():
        order = np.concatenate([order, np.flatnonzero(structure.searched)])
        values = np.concatenate([fit.parameters, x[structure.searched]])
        regressions, residuals, free = _with_searched(regressions, residuals, free, structure, x)
    error = uncertainty_of(regressions, residuals, joint_noise, loss, interval_method, free)
    scale = gain_uncertainty(prepared)
    gain = 0.0 if relative else scale
    propagated = 0.0 if x is None else _propagated(regressions, residuals, joint_noise, loss, structure, x)[order]
    linear = structure.linear[order]
    bodies = physical_consistency.no_bodies(prepared[0].mechanism, fit.parameters, error.covariance)
    intervals, shapes = (error.interval(values, np.where(linear, share, 0.0), propagated) for share in (gain, 0.0))
    assessment = Assessment(
        source=interval_method,
        loss=loss,
        absolute=not relative,
        gain_uncertainty=gain,
        scale_uncertainty=scale,
        correlation=tuple(tuple(number_or_none(x) for x in row) for row in error.correlation),
        condition_number=conditioning.condition,
        singular_values=conditioning.singular_values,
        inseparable=conditioning.combinations,
        noise=_noise(joint_noise, prepared[0].recording),
        floor=_floor(cycle_statistics.of_residuals(prepared, residuals)),
        warnings=(
            *physical_consistency.violations(structure.linear_parameters, fit.parameters, intervals[linear]),
            *([bodies] if bodies else []),
        ),
        coupling=physical_consistency.coupling(_rigid_torque(structure, fit.parameters), prepared[0].motion),
        cutoffs=tuple(hz for hz, _ in parameter_changes.per_cutoff),
    )
    known: tuple[Status | None, ...] = tuple("identifiable" if each else "not" for each in free[~linear])
    status = (*conditioning.status, *known)
    return assessment, _parameter_uncertainties(error, intervals, shapes, status, parameter_changes)


def _with_searched(
    regressions: Sequence[Regression], residuals: Sequence[Floats], free: Bools, structure: ModelStructure, x: Floats
) -> tuple[list[Regression], list[Floats], Bools]:
    """Regressors with the derivatives by what was searched of `x` (K,) behind their columns; which are `free`."""
    columns = [
        np.concatenate([each.regressor, chunks.linearized(each.prepared, structure, x, searched=True)[1]], axis=2)
        for each in regressions
    ]
    residuals = [
        np.where(np.isfinite(each).all(axis=2), residual, np.nan)
        for each, residual in zip(columns, residuals, strict=True)
    ]
    whole = [replace(each, regressor=regressor) for each, regressor in zip(regressions, columns, strict=True)]
    rows = np.concatenate([each[np.isfinite(residual)] for each, residual in zip(columns, residuals, strict=True)])
    free = np.concatenate([free, [structure.parameters[i].free for i in np.flatnonzero(structure.searched)]])
    free &= (rows != 0).any(axis=0)
    free[free] = independent(rows[:, free] / np.linalg.norm(rows[:, free], axis=0))
    return whole, residuals, free


def _rigid_torque(structure: ModelStructure, linear: Floats) -> Callable[[Motion], Floats]:
    """The torque of the mechanism with its mandatory effects, which carry mass."""
    terms = tuple(term for term in structure.terms if term.effect.mandatory)
    entries = [entry for entry in structure.parameters if entry.linear]
    of_terms = [entry.term >= 0 and structure.terms[entry.term].effect.mandatory for entry in entries]
    values = np.concatenate([structure.mechanism_values(linear), linear[np.array(of_terms, bool)]])
    rigid = InverseDynamics(replace(structure, terms=terms), values)
    return lambda motion: rigid.torque(rigid.inputs(motion))


def _noise(joint_noise: Sequence[noise.Noise], recording: Recording) -> tuple[JointNoise, ...]:
    rig = recording.rig
    units = rig.effort_units if holds_torque(recording) else ("V",) * rig.dof
    return tuple(JointNoise(unit=unit, **asdict(joint)) for joint, unit in zip(joint_noise, units, strict=True))


def gain_uncertainty(prepared: Sequence[PreparedRecording]) -> float:
    """Largest relative standard uncertainty of the gains of recordings; 0 if the effort itself was measured."""
    recordings = [each.recording for each in prepared]
    # That of each recording counts in full: a parameter may be seen in one alone.
    return max(0.0 if holds_torque(each) else each.rig.torque.gain_uncertainty for each in recordings)


def loss_of(fit: Fit, method: str) -> Loss:
    """Objective that the estimator `method` minimises."""
    if fit.estimate.certificate is not None:
        return "absolute deviations"
    return "weighted squares" if estimators.declares(method, "WEIGHTED") else "squares"


def _gram(regressions: Sequence[Regression]) -> Floats:
    return np.sum([rows.T @ rows for rows in (regression.rows()[0] for regression in regressions)], axis=0)


def uncertainty_of(
    regressions: Sequence[Regression],
    residuals: Sequence[Floats],
    joint_noise: Sequence[noise.Noise],
    loss: Loss,
    interval_method: IntervalMethod,
    free: Bools,
) -> Uncertainty:
    """Uncertainty of the `free` parameters (k,), given the `residuals` of the fit; NaN for the others."""
    blocks, cycles = [], 0
    for regression, residual in zip(regressions, residuals, strict=True):
        std = noise.residual_std(regression.prepared, residual, joint_noise)
        repeat = regression.prepared.repeat
        cycle = np.where(repeat >= 0, repeat + cycles, -1)
        cycles = int(cycle.max()) + 1
        regressor = regression.regressor[:, :, free]
        if loss == "absolute deviations":
            blocks.append(covariance.least_absolute(regressor, residual, std, cycle))
        else:
            weight = 1 / std if loss == "weighted squares" else None
            blocks.append(covariance.least_squares(regressor, residual, std, cycle, weight))
    return covariance.estimate(blocks, interval_method).expanded(free)


def _propagated(
    regressions: Sequence[Regression],
    residuals: Sequence[Floats],
    joint_noise: Sequence[noise.Noise],
    loss: Loss,
    structure: ModelStructure,
    x: Floats,
) -> Floats:
    """(K,) mean square errors of the parameters `x` (K,) that are no noise."""
    # Small errors shift the minimum of absolute deviations like that of squares with this weight: the density of the
    # noise, by which its curvature is weighted, falls with the standard deviation.
    power = {"squares": 0.0, "weighted squares": -1.0, "absolute deviations": -0.5}[loss]
    weights = [
        np.where(np.isfinite(residual), noise.residual_std(regression.prepared, residual, joint_noise) ** power, 0.0)
        for regression, residual in zip(regressions, residuals, strict=True)
    ]
    recordings = [regression.prepared for regression in regressions]
    return propagated_variance(recordings, structure, x, weights)


def _parameter_uncertainties(
    error: Uncertainty,
    intervals: Floats,
    shapes: Floats,
    known: Sequence[Status | None],
    parameter_changes: sensitivity.Sensitivity,
) -> tuple[ParameterUncertainty, ...]:
    return tuple(
        ParameterUncertainty(
            std=number_or_none(error.std[i]),
            ci95=interval_or_none(intervals[i]),
            shape_ci95=interval_or_none(shapes[i]),
            degrees_of_freedom=number_or_none(error.degrees_of_freedom[i]),
            status=status,
            per_length_step=None
            if parameter_changes.per_length_step is None
            else float(parameter_changes.per_length_step[i]),
            per_cutoff=tuple(float(change[i]) for _, change in parameter_changes.per_cutoff),
        )
        for i, status in enumerate(known)
    )


def _floor(splits: Sequence[cycle_statistics.CycleStatistics] | None) -> tuple[JointFloor, ...] | None:
    if splits is None:
        return None
    return tuple(
        JointFloor(
            cycles=split.cycles,
            noise_rms=split.noise_rms,
            total=split.total,
            noise=split.noise,
            repeating=split.repeating,
            repeating_p=split.repeating_p,
            above_noise=split.above_noise,
            trend=split.trend if split.trend and split.trend.significant else None,
        )
        for split in splits
    )


def interval_or_none(limits: Floats) -> tuple[float, float] | None:
    """The two `limits` (2,) of an interval; None where they are not known."""
    low, high = limits.tolist()
    return (low, high) if np.isfinite(limits).all() else None


def number_or_none(x: float) -> OptionalFloat:
    """`x`; None where it is not known."""
    return float(x) if np.isfinite(x) else None

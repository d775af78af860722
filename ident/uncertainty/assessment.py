"""How far a fit can be trusted: everything that is known about its errors, as it stands in the model file."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Literal

import numpy as np

from ident.data import cycle_statistics, noise
from ident.data.dataset import Dataset
from ident.data.samples import holds_torque
from ident.dynamics.mechanisms import Mechanism
from ident.estimation import estimators
from ident.estimation.linear_fit import Fit
from ident.uncertainty import covariance, physical_consistency, sensitivity
from ident.uncertainty.covariance import IntervalMethod, Uncertainty
from ident.uncertainty.identifiability import Identifiability, Status, identifiability
from recordings.config import Section
from recordings.recording import Bools, Floats, Recording

OptionalFloat = float | None
Loss = Literal["absolute deviations", "squares", "weighted squares"]


class ParameterUncertainty(Section):
    """How well one parameter is known, in its unit. None where the data do not tell: at a bound, or inseparable."""

    std: OptionalFloat = None
    """Standard error, of the noise alone."""
    ci95: tuple[float, float] | None = None
    """95 % interval; see `Trust`."""
    degrees_of_freedom: OptionalFloat = None
    """Of the standard error; None where it is as good as exact."""
    status: Status | None = None
    """Whether the motion tells this parameter from the others."""
    per_length_step: OptionalFloat = None
    """Change where the forearms are 10 mm longer."""
    per_cutoff: tuple[float, ...] = ()
    """Change at each of `Trust.cutoffs`."""


class JointNoise(Section):
    """Noise of one joint in the analysis band."""

    volts: float
    """Standard deviation of what was measured of the drive, in `unit`."""
    unit: str
    """V, or the effort's where that was measured."""
    floor: float
    """Standard deviation of the torque at zero voltage [N m]."""
    source: Literal["repetition", "band above the signal"]


class JointTrend(Section):
    """How a joint's residual changes from one repetition to the next."""

    pattern: str
    p_value: float
    mean_square: float


class JointFloor(Section):
    """The mean square of one joint's residual [(N m)^2], split by what repeats with the motion."""

    cycles: int
    noise_rms: float
    """[N m]: the noise floor."""
    total: float
    noise: float
    repeating: float
    repeating_p: float
    above_noise: float
    """Share of the mean square that is not noise."""
    trend: JointTrend | None
    """Only a significant one."""


class Inseparable(Section):
    """Parameters that the motion does not tell apart."""

    names: tuple[str, ...]
    status: Literal["weak", "not"]
    sentence: str


class JointCoupling(Section):
    """The inertia matrix D of Eq. (27) along the recording."""

    off_diagonal: tuple[tuple[float, ...], ...]
    share: float
    positive: bool


class ImplausibleParameter(Section):
    """A parameter that no real machine can have."""

    name: str
    significant: bool
    sentence: str


class Assessment(Section):
    """What is known about the errors of a fit."""

    level: float = covariance.LEVEL
    source: IntervalMethod
    """How the noise's autocovariance was found, see `ident.uncertainty.covariance`."""
    loss: Loss
    """What the intervals are for: the estimator's objective."""
    absolute: bool
    """True where intervals are of absolute values, the gain's uncertainty included; else only ratios are claimed."""
    gain_uncertainty: float
    """Relative standard uncertainty that the intervals include."""
    correlation: tuple[tuple[OptionalFloat, ...], ...]
    """Between the errors of the parameters, in their order."""
    condition_number: float
    singular_values: tuple[float, ...]
    inseparable: tuple[Inseparable, ...]
    noise: tuple[JointNoise, ...]
    floor: tuple[JointFloor, ...] | None
    """None where the motion is not repeated."""
    doubts: tuple[ImplausibleParameter, ...]
    coupling: JointCoupling | None
    cutoffs: tuple[float, ...]
    """Other cut-offs that were tried [Hz]."""


def assess(
    datasets: Sequence[Dataset],
    fit: Fit,
    mechanism: Mechanism,
    method: str,
    parameter_changes: sensitivity.Sensitivity,
    relative: bool,
    interval_method: IntervalMethod = "stationary",
) -> tuple[Assessment, tuple[ParameterUncertainty, ...]]:
    """Judge `fit` of `datasets` by the estimator `method`: as a whole, and parameter by parameter.

    `moved` is what other assumptions do to the parameters; `relative`: they are known up to one common factor.
    """
    residuals = [dataset.torque - fit.torque(dataset) for dataset in datasets]
    found = noise.estimate(datasets, residuals)
    loss = loss_of(fit, method)
    known = identifiability(_gram(datasets), mechanism.parameters)
    free = np.array([s != "not" and not b for s, b in zip(known.status, fit.at_bound, strict=True)])
    error = uncertainty_of(datasets, residuals, found, loss, interval_method, free)
    gain = 0.0 if relative else _gain_uncertainty(datasets[0].recording)
    intervals = error.interval(fit.parameters, gain)
    trust = Assessment(
        source=interval_method,
        loss=loss,
        absolute=not relative,
        gain_uncertainty=gain,
        correlation=tuple(tuple(_number(x) for x in row) for row in error.correlation),
        condition_number=known.condition,
        singular_values=known.singular_values,
        inseparable=tuple(
            Inseparable(names=c.names, status=c.status, sentence=c.sentence) for c in known.combinations
        ),
        noise=_noise(found, datasets[0].recording),
        floor=_floor(cycle_statistics.of_residuals(datasets, residuals)),
        doubts=tuple(
            ImplausibleParameter(name=d.name, significant=d.significant, sentence=d.sentence)
            for d in physical_consistency.violations(mechanism.parameters, fit.parameters, intervals)
        ),
        coupling=_coupling(mechanism, datasets, fit.parameters),
        cutoffs=tuple(hz for hz, _ in parameter_changes.per_cutoff),
    )
    return trust, _knowledge(error, intervals, known, parameter_changes)


def _noise(found: Sequence[noise.Noise], recording: Recording) -> tuple[JointNoise, ...]:
    rig = recording.rig
    units = rig.effort_units if holds_torque(recording) else ("V",) * rig.dof
    return tuple(JointNoise(unit=unit, **asdict(joint)) for joint, unit in zip(found, units, strict=True))


def _gain_uncertainty(recording: Recording) -> float:
    """Relative; where the effort itself was measured, no gain is needed."""
    return 0.0 if holds_torque(recording) else recording.rig.torque.gain_uncertainty


def loss_of(fit: Fit, method: str) -> Loss:
    """What the estimator `method` minimises."""
    if fit.estimate.certificate is not None:
        return "absolute deviations"
    return "weighted squares" if estimators.weighted(method) else "squares"


def _gram(datasets: Sequence[Dataset]) -> Floats:
    gram: Floats = np.sum([rows.T @ rows for rows in (dataset.rows()[0] for dataset in datasets)], axis=0)
    return gram


def uncertainty_of(
    datasets: Sequence[Dataset],
    residuals: Sequence[Floats],
    joint_noise: Sequence[noise.Noise],
    loss: Loss,
    interval_method: IntervalMethod,
    free: Bools,
) -> Uncertainty:
    """Of the parameters that are `free` (k,); NaN for the others. The fit left `residuals` with the noise `found`."""
    parts, cycles = [], 0
    for dataset, residual in zip(datasets, residuals, strict=True):
        std = noise.residual_std(dataset, residual, joint_noise)
        cycle = np.where(dataset.repeat >= 0, dataset.repeat + cycles, -1)
        cycles = int(cycle.max()) + 1
        regressor = dataset.regressor[:, :, free]
        if loss == "absolute deviations":
            parts.append(covariance.least_absolute(regressor, residual, std, cycle))
        else:
            weight = 1 / std if loss == "weighted squares" else None
            parts.append(covariance.least_squares(regressor, residual, std, cycle, weight))
    return covariance.estimate(parts, interval_method).expanded(free)


def _knowledge(
    error: Uncertainty, intervals: Floats, known: Identifiability, moved: sensitivity.Sensitivity
) -> tuple[ParameterUncertainty, ...]:
    return tuple(
        ParameterUncertainty(
            std=_number(error.std[i]),
            ci95=(float(intervals[i, 0]), float(intervals[i, 1])) if np.isfinite(intervals[i]).all() else None,
            degrees_of_freedom=_number(error.degrees_of_freedom[i]),
            status=status,
            per_length_step=None if moved.per_length_step is None else float(moved.per_length_step[i]),
            per_cutoff=tuple(float(change[i]) for _, change in moved.per_cutoff),
        )
        for i, status in enumerate(known.status)
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
            trend=JointTrend(**asdict(split.trend)) if split.trend and split.trend.significant else None,
        )
        for split in splits
    )


def _coupling(mechanism: Mechanism, datasets: Sequence[Dataset], parameters: Floats) -> JointCoupling | None:
    found = physical_consistency.coupling(mechanism, datasets[0].motion, parameters)
    return None if found is None else JointCoupling(**asdict(found))


def _number(x: float) -> OptionalFloat:
    return float(x) if np.isfinite(x) else None

"""Assessment of a fit: each part comes from the right statistic."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ident.data import noise
from ident.estimation import estimators
from ident.estimation.linear_fit import Fit, fit
from ident.estimation.regression import Regression
from ident.uncertainty import sensitivity
from ident.uncertainty.assessment import Assessment, ParameterUncertainty, assess, loss_of, uncertainty_of
from recordings.recording import Recording
from tests.ident import building

NOISE = 0.1
UNCHANGED = sensitivity.Sensitivity(None, ())


def fitted(*recordings: Recording, method: str = "svd") -> tuple[list[Regression], Fit]:
    regressions = [building.regression(recording) for recording in recordings]
    parameters, settings = building.structure(recordings[0]).linear_parameters, estimators.settings(method, {})
    return regressions, fit(regressions, parameters, method, settings, np.random.default_rng(0), lambda *_: None)


def assessed(
    *recordings: Recording, method: str = "svd", changes: sensitivity.Sensitivity = UNCHANGED, **options: Any
) -> tuple[Assessment, tuple[ParameterUncertainty, ...]]:
    regressions, result = fitted(*recordings, method=method)
    return assess(regressions, result, building.structure(recordings[0]), method, changes, False, **options)


def test_noise_floor_and_model_error_are_those_of_the_residual() -> None:
    assessment, _ = assessed(building.record(noise=NOISE, cycles=6))
    expected = NOISE * np.sqrt(2 * building.CUTOFF / building.RATE)
    (joint,), (level,) = assessment.floor or (), assessment.noise
    assert joint.cycles == 6
    assert joint.noise_rms == pytest.approx(expected, rel=0.1)
    assert joint.above_noise < 0.1
    assert joint.trend is None
    assert (level.unit, level.source) == ("N m", "repetition")
    assert np.hypot(level.volts, level.floor) == pytest.approx(expected, rel=0.1)
    (wrong,) = assessed(building.record(noise=NOISE, extra=building.drag))[0].floor or ()
    assert wrong.above_noise > 0.8
    assert wrong.repeating_p < 1e-6
    assert assessed(building.record(cycles=1, noise=NOISE))[0].floor is None


@pytest.mark.parametrize(
    ("method", "loss"), [("svd", "squares"), ("wls", "weighted squares"), ("lad", "absolute deviations")]
)
def test_intervals_belong_to_the_loss_of_the_estimator(method: str, loss: str) -> None:
    assessment, parameters = assessed(building.record(noise=NOISE, seed=3), method=method)
    assert assessment.loss == loss
    for truth, parameter in zip(building.parameters(), parameters, strict=True):
        assert parameter.std is not None
        assert parameter.ci95 is not None
        assert parameter.ci95[0] - 2 * parameter.std < truth < parameter.ci95[1] + 2 * parameter.std
        assert parameter.status == "identifiable"


@pytest.mark.slow
@pytest.mark.parametrize("method", ["svd", "wls", "lad"])
def test_intervals_of_fitted_recordings_cover_the_truth(method: str) -> None:
    """Through the preprocessing, as `ident fit`: 300 recordings, three parameters; binomial error 0.7 %."""
    recording = building.record()
    exact, settings = building.prepared(recording), estimators.settings(method, {})
    rng, inside = np.random.default_rng(0), []
    for _ in range(300):
        noisy = building.with_noise(exact, NOISE * rng.normal(size=recording.position.shape))
        rows = Regression.of_mechanism(noisy)
        result = fit([rows], exact.mechanism.parameters, method, settings, rng, lambda *_: None)
        residuals = [rows.residual(result.parameters)]
        levels, free = noise.estimate([noisy], residuals), np.ones(3, bool)
        error = uncertainty_of([rows], residuals, levels, loss_of(result, method), "stationary", free)
        inside.append(np.abs(result.parameters - building.parameters()) <= error.half_width())
    assert 0.93 <= np.mean(inside) <= 0.97, np.mean(inside, axis=0)


def test_more_recordings_narrow_the_intervals_by_the_square_root() -> None:
    """Their cycles are different blocks."""
    recordings = [building.record(cycles=3, noise=NOISE, seed=seed) for seed in range(4)]
    single, four = (assessed(*part)[1] for part in (recordings[:1], recordings))
    ratios = [a.std / b.std for a, b in zip(single, four, strict=True) if a.std and b.std]
    assert np.mean(ratios) == pytest.approx(2.0, rel=0.15)
    _, parameters = assessed(*recordings[:2], interval_method="cycles")
    assert [parameter.degrees_of_freedom for parameter in parameters] == [5.0, 5.0, 5.0]


def test_collinear_parameters_have_no_interval_and_are_named() -> None:
    """The third column is a copy of the first."""
    recording = building.record(noise=NOISE)
    regressions, result = fitted(recording)
    twice = replace(
        regressions[0], regressor=np.concatenate([regressions[0].regressor[:, :, :2]] * 2, axis=2)[:, :, :3]
    )
    assessment, parameters = assess([twice], result, building.structure(recording), "svd", UNCHANGED, False)
    assert [parameter.status for parameter in parameters] == ["not", "identifiable", "not"]
    assert [parameter.ci95 is None for parameter in parameters] == [True, False, True]
    (inseparable,) = assessment.inseparable
    assert set(inseparable.names) == {"I_1", "c_c1"}
    assert assessment.correlation[0][0] is None


def test_parameter_at_a_bound_has_no_interval() -> None:
    recording = building.record(noise=NOISE)
    regressions, result = fitted(recording)
    at_bound = replace(result, bounds=np.array([[-9.0, 9.0], [result.parameters[1], 9.0], [-9.0, 9.0]]))
    _, parameters = assess(regressions, at_bound, building.structure(recording), "svd", UNCHANGED, False)
    assert [parameter.std is None for parameter in parameters] == [False, True, False]


def test_measured_effort_has_no_uncertain_gain_and_changes_are_passed_on() -> None:
    changes = sensitivity.Sensitivity(np.array([1.0, 2.0, 3.0]), ((15.0, np.array([0.1, 0.2, 0.3])),))
    assessment, parameters = assessed(building.record(noise=NOISE), changes=changes)
    assert assessment.gain_uncertainty == 0.0
    assert assessment.cutoffs == (15.0,)
    assert [parameter.per_length_step for parameter in parameters] == [1.0, 2.0, 3.0]
    assert [parameter.per_cutoff for parameter in parameters] == [(0.1,), (0.2,), (0.3,)]
    assert assessment.warnings == ()
    assert assessment.coupling is None


def test_impossible_parameter_is_reported() -> None:
    driving = building.record(noise=NOISE, extra=lambda motion: -2.0 * motion.velocity)
    (warning,) = assessed(driving)[0].warnings
    assert (warning.name, warning.significant) == ("c_v1", True)

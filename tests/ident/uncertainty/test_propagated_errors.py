"""Errors of parameters that repeat with the motion."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.estimation import estimators
from ident.estimation.linear_fit import fit
from ident.uncertainty.assessment import assess
from ident.uncertainty.propagated_errors import PropagatedErrors, propagated_variance, repetition_factor
from ident.uncertainty.sensitivity import Sensitivity
from tests.ident import building

ROWS, STEPS = 4000, 0.05
BIAS = -2.0 * STEPS**2 / (0.5 + STEPS**2)
"""Of the parameter of `_regression`, 2.0, because the signal contains errors."""


def _regression(
    rng: np.random.Generator, repeated: bool = False, residual_share: float = 1.0
) -> tuple[PropagatedErrors, float]:
    """Propagated errors of a regression on a signal with quantization errors, in four cycles; the actual error."""
    moved = np.tile(np.sin(np.linspace(0, 2 * np.pi, ROWS // 4, endpoint=False)), 4)
    error = np.tile(rng.normal(size=ROWS // 4), 4) if repeated else rng.normal(size=ROWS)
    read = moved + STEPS * error
    torque = 2.0 * moved + 1e-6 * rng.normal(size=ROWS)
    x = np.array([read @ torque / (read @ read)])

    def predictor(signal: Any) -> Any:
        return SimpleNamespace(
            torque=lambda structure, x: signal[:, None] * x,
            linearized=lambda structure, x: (signal[:, None] * x, signal[:, None, None]),
        )

    perturbed = [[predictor(read + STEPS * rng.normal(size=ROWS))] for _ in range(8)]
    residual = residual_share * (torque - read * x[0])[:, None]
    solution: Any = SimpleNamespace(
        structure=SimpleNamespace(parameters=(SimpleNamespace(free=True),)),
        x=x,
        weights=(np.ones((ROWS, 1)),),
        residuals=(residual,),
        derivatives=(read[:, None, None],),
        rows=lambda: (read[:, None], residual[:, 0]),
    )
    cycles: Any = SimpleNamespace(repeat=np.repeat(np.arange(4), ROWS // 4))
    repetition = repetition_factor([cycles], [np.array([float(repeated)])])
    return PropagatedErrors([predictor(read)], perturbed, solution, repetition), float(x[0] - 2.0)


def _encoder_variance(errors: PropagatedErrors) -> float:
    return float(sum(shift[0] ** 2 for shift in errors.encoder_shifts()))


@pytest.mark.parametrize("repeated", [False, True])
def test_encoder_step_errors_match_the_actual_scatter(repeated: bool) -> None:
    rng = np.random.default_rng(1)
    predicted, actual = [], []
    for _ in range(40):
        errors, error = _regression(rng, repeated)
        predicted.append(_encoder_variance(errors))
        actual.append(error - BIAS)
    scatter = np.sqrt(np.mean(np.square(actual)))
    assert np.sqrt(np.mean(predicted)) == pytest.approx(scatter, rel=0.4)


def test_encoder_step_errors_are_limited_by_the_residual() -> None:
    whole, tenth = (_regression(np.random.default_rng(2), residual_share=share)[0] for share in (1.0, 0.1))
    assert _encoder_variance(tenth) == pytest.approx(_encoder_variance(whole) / 100, rel=0.1)
    assert tenth.attenuation_bias()[0] == pytest.approx(whole.attenuation_bias()[0] / 100, rel=0.1)


def test_attenuation_by_encoder_steps_is_found_from_one_draw() -> None:
    for seed in range(5):
        errors, error = _regression(np.random.default_rng(seed), True)
        assert errors.attenuation_bias()[0] == pytest.approx(BIAS, rel=0.1)
        assert abs(error - BIAS) < abs(error)


@pytest.mark.parametrize("method", ["svd", "wls", "lad"])
def test_intervals_of_a_fit_hold_inertias_that_a_coarse_encoder_attenuates(method: str) -> None:
    """The inertia is half a percent too small, always to the same side, and by more than its scatter."""
    recording = building.record(noise=0.1, encoder_step=3e-4)
    regression, structure = building.regression(recording), building.structure(recording)
    parameters, settings = structure.linear_parameters, estimators.settings(method, {})
    result = fit([regression], parameters, method, settings, np.random.default_rng(0), lambda *_: None)
    inside = []
    for x in (None, result.parameters):
        _, (inertia, *_others) = assess([regression], result, structure, method, Sensitivity(None, ()), False, x=x)
        assert inertia.ci95 is not None
        inside.append(inertia.ci95[0] < building.INERTIA < inertia.ci95[1])
    assert inside == [False, True]


def test_errors_of_a_long_recording_are_those_of_its_first_chunk(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bias stays, and the scatter falls with the number of rows."""
    exact = building.prepared(building.record(cycles=8, encoder_step=3e-4))
    weights, x = [np.where(exact.usable, 1.0, 0.0)], building.parameters()
    whole = propagated_variance([exact], exact.base_structure, x, weights)
    monkeypatch.setattr("ident.estimation.chunks.CHUNK_LENGTH", 4000)
    monkeypatch.setattr("ident.estimation.chunks.RUN_IN", 0.5)
    first = propagated_variance([exact], exact.base_structure, x, weights)
    np.testing.assert_allclose(np.sqrt(first), np.sqrt(whole), rtol=0.5)

"""Confidence intervals of the parameters."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.parameter_intervals import encoder_step_errors

ROWS, STEPS = 4000, 0.05


def _regression(rng: np.random.Generator, repeated: bool) -> tuple[Any, Any, float]:
    """A regression on a signal with quantization errors, in four cycles; its solution; and its parameter's error."""
    moved = np.tile(np.sin(np.linspace(0, 2 * np.pi, ROWS // 4, endpoint=False)), 4)
    error = np.tile(rng.normal(size=ROWS // 4), 4) if repeated else rng.normal(size=ROWS)
    read = moved + STEPS * error
    torque = 2.0 * moved + 1e-6 * rng.normal(size=ROWS)
    x = np.array([read @ torque / (read @ read)])

    def predictor(signal: Any) -> Any:
        return SimpleNamespace(torque=lambda structure, x: signal[:, None] * x)

    perturbed = tuple((predictor(read + STEPS * rng.normal(size=ROWS)),) for _ in range(8))
    split = SimpleNamespace(
        predictors=(predictor(read),),
        datasets=(SimpleNamespace(repeat=np.repeat(np.arange(4), ROWS // 4)),),
        repeating_share=(np.array([float(repeated)]),),
        train_indices=(0,),
        perturbed_draws=perturbed,
    )
    residual = (torque - read * x[0])[:, None]
    solution = SimpleNamespace(
        structure=SimpleNamespace(parameters=(SimpleNamespace(free=True),)),
        x=x,
        weights=(np.ones((ROWS, 1)),),
        residuals=(residual,),
        rows=lambda: (read[:, None], residual[:, 0]),
    )
    bias = -2.0 * STEPS**2 / (0.5 + STEPS**2)
    return split, solution, float(x[0] - 2.0 - bias)


@pytest.mark.parametrize("repeated", [False, True])
def test_encoder_step_errors_match_the_actual_scatter(repeated: bool) -> None:
    rng = np.random.default_rng(1)
    predicted, actual = [], []
    for _ in range(40):
        split, solution, error = _regression(rng, repeated)
        predicted.append(encoder_step_errors(split, solution)[0])
        actual.append(error)
    scatter = np.sqrt(np.mean(np.square(actual)))
    assert np.sqrt(np.mean(np.square(predicted))) == pytest.approx(scatter, rel=0.4)


def test_encoder_step_errors_are_limited_by_the_residual() -> None:
    split, solution, _ = _regression(np.random.default_rng(2), False)
    before = encoder_step_errors(split, solution)
    regressor, residual = solution.rows()
    solution.rows = lambda: (regressor, residual / 10)
    assert encoder_step_errors(split, solution) == pytest.approx(before / 10, rel=0.1)

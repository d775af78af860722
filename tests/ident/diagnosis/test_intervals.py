"""How well parameters are known."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.intervals import encoder_step_errors

ROWS, STEPS = 4000, 0.05


def _read(rng: np.random.Generator, repeated: bool) -> tuple[Any, Any, float]:
    """A regression on a signal that was read with errors, in four cycles; its solution; and its parameter's error."""
    moved = np.tile(np.sin(np.linspace(0, 2 * np.pi, ROWS // 4, endpoint=False)), 4)
    error = np.tile(rng.normal(size=ROWS // 4), 4) if repeated else rng.normal(size=ROWS)
    read = moved + STEPS * error
    torque = 2.0 * moved + 1e-6 * rng.normal(size=ROWS)
    x = np.array([read @ torque / (read @ read)])

    def evaluator(signal: Any) -> Any:
        return SimpleNamespace(torque=lambda composition, x: signal[:, None] * x)

    misread = tuple((evaluator(read + STEPS * rng.normal(size=ROWS)),) for _ in range(8))
    material = SimpleNamespace(
        evaluators=(evaluator(read),),
        datasets=(SimpleNamespace(repeat=np.repeat(np.arange(4), ROWS // 4)),),
        repeating=(np.array([float(repeated)]),),
        fitting=(0,),
        misreadings=misread,
    )
    residual = (torque - read * x[0])[:, None]
    solution = SimpleNamespace(
        composition=SimpleNamespace(named=(SimpleNamespace(free=True),)),
        x=x,
        weights=(np.ones((ROWS, 1)),),
        residuals=(residual,),
        rows=lambda: (read[:, None], residual[:, 0]),
    )
    bias = -2.0 * STEPS**2 / (0.5 + STEPS**2)
    return material, solution, float(x[0] - 2.0 - bias)


@pytest.mark.parametrize("repeated", [False, True])
def test_what_encoder_steps_make_of_a_parameter_is_foretold(repeated: bool) -> None:
    rng = np.random.default_rng(1)
    told, happened = [], []
    for _ in range(40):
        material, solution, error = _read(rng, repeated)
        told.append(encoder_step_errors(material, solution)[0])
        happened.append(error)
    scatter = np.sqrt(np.mean(np.square(happened)))
    assert np.sqrt(np.mean(np.square(told))) == pytest.approx(scatter, rel=0.4)


def test_no_reading_is_thought_to_leave_more_than_is_left() -> None:
    material, solution, _ = _read(np.random.default_rng(2), False)
    before = encoder_step_errors(material, solution)
    regressor, residual = solution.rows()
    solution.rows = lambda: (regressor, residual / 10)
    assert encoder_step_errors(material, solution) == pytest.approx(before / 10, rel=0.1)

"""Training rows and test rows of recordings."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.library import library


def test_errors_in_a_regressor_attenuate_the_parameters() -> None:
    rng = np.random.default_rng(0)
    measured = rng.normal(size=(20_000, 1, 1))
    perturbed = measured + 0.5 * rng.normal(size=measured.shape)
    train = np.ones((len(measured), 1), bool)
    predictors = [
        SimpleNamespace(linearized=lambda bare, x, columns=columns: (None, columns))
        for columns in (measured, perturbed)
    ]
    split: Any = SplitData((predictors[0],), (train,), (~train,), (np.where(train, 3.0, 0.0),), True)  # type: ignore[arg-type]
    split.__dict__["perturbed"] = (predictors[1],)
    columns, bias = split.perturbed_regressors(SimpleNamespace(terms=(), parameters=(None,)))
    assert columns == [(measured, perturbed)]
    # -E[perturbed (perturbed - measured)] / E[perturbed^2]
    assert bias == pytest.approx(-0.25 / 1.25, rel=0.05)


def _with_saturation(amplified: float, share: float) -> tuple[Any, Any]:
    """Data of one joint, in which a `share` of the rows amplifies errors by a factor; and a solution."""
    size = np.where(np.arange(1000) < 1000 * share, amplified, 1.0)[:, None]
    prepared = SimpleNamespace(condition=lambda signal: signal, regressor=np.zeros((1000, 1, 3)))
    predictor: Any = SimpleNamespace(prepared=prepared, error_amplification=lambda structure, x, error: size)
    rows = np.ones((1000, 1), bool)
    split = SplitData((predictor, predictor), (rows, ~rows), (~rows, rows), (rows * 1.0, rows * 0.0), True)
    split.__dict__["outside_of_travel"] = (~rows, ~rows)
    term = SimpleNamespace(effect=library()["amplifier_saturation"], joints=(0,))
    return split, SimpleNamespace(structure=SimpleNamespace(terms=(term,)), x=np.zeros(1))


def test_saturated_rows_are_fitted_but_not_scored() -> None:
    all_rows, solution = _with_saturation(amplified=5.0, share=0.1)
    reduced = all_rows.judged(solution, np.ones(1))
    assert reduced.unjudged_shares == pytest.approx((0.1,))
    assert [int(rows.sum()) for rows in (reduced.train[0], reduced.test[1])] == [900, 900]
    assert reduced.weights is all_rows.weights


@pytest.mark.parametrize(("amplified", "share"), [(1.5, 0.5), (5.0, 1.0)])
def test_little_amplification_or_nothing_else_changes_nothing(amplified: float, share: float) -> None:
    all_rows, solution = _with_saturation(amplified, share)
    assert all_rows.judged(solution, np.ones(1)) is all_rows


def test_rows_without_a_prediction_do_not_count() -> None:
    residual = np.array([[3.0], [np.nan], [4.0], [9.0]])
    selected = np.array([[True], [True], [True], [False]])
    assert rms([residual], [selected]) == pytest.approx(np.sqrt(12.5))

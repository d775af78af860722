"""Nonlinear least squares on recordings with known parameters."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import (
    Solution,
    _neighbors,
    _solve,
    escape_local_minima,
    initial_solution,
    levenberg_marquardt,
    nonlinear_least_squares,
)
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats, Recording
from tests.ident import building

BUMP, SPEED, STEP = 0.8, 0.6, 0.04


def stribeck(motion: Motion) -> Floats:
    bump: Floats = BUMP * np.exp(-((motion.velocity / SPEED) ** 2)) * motion.direction
    return bump


def predictor(recording: Recording) -> tuple[TorquePredictor, Floats]:
    prepared = building.prepared(recording)
    return TorquePredictor(prepared), np.where(prepared.usable, 1.0, 0.0)


def test_linear_model_is_the_weighted_least_squares_solution() -> None:
    predicted, weight = predictor(building.record(2, noise=0.1))
    weight *= np.linspace(1.0, 3.0, len(weight))[:, None]
    structure = building.structure(predicted.prepared.recording)
    solution = nonlinear_least_squares([predicted], structure, np.zeros(6), [weight])
    regressor, torque = solution.rows()
    expected = np.linalg.lstsq(regressor, torque + regressor @ solution.x, rcond=None)[0]
    np.testing.assert_allclose(solution.x, expected, rtol=1e-8)
    assert solution.loss == pytest.approx(float(torque @ torque))
    np.testing.assert_allclose(solution.x, building.parameters(2), rtol=0.03)


@pytest.mark.parametrize("start", [0.3, 0.6, 1.2])
def test_shape_is_found_from_several_starts(start: float) -> None:
    predicted, weight = predictor(building.record(extra=stribeck, noise=0.01))
    structure = building.structure(predicted.prepared.recording, "stribeck")
    guess = np.array([0.0, 0.0, 0.0, 0.0, start])
    solution = nonlinear_least_squares([predicted], structure, guess, [weight])
    np.testing.assert_allclose(solution.x, [*building.parameters(), BUMP, SPEED], rtol=0.03)


@pytest.mark.parametrize("start", [0.35, 0.9])
def test_search_escapes_from_the_steps_of_a_discontinuous_effect(start: float) -> None:
    """The torque changes only from step to step of the shape, whose derivative is 0."""
    predicted, weight = predictor(building.record(extra=stribeck, noise=0.01))
    smooth = library()["stribeck"]
    assert isinstance(smooth, Additive)
    steps = replace(
        smooth,
        columns=lambda inputs, shapes: smooth.columns(inputs, {"v_s": STEP * round(shapes["v_s"] / STEP)}),
        discontinuous=True,
    )
    structure = predicted.prepared.base_structure.with_term(Term("steps", steps, (0,)))
    stuck = nonlinear_least_squares([predicted], structure, np.array([0.0, 0.0, 0.0, 0.0, start]), [weight])
    assert stuck.x[-1] == pytest.approx(start)
    escaped = escape_local_minima([predicted], stuck, [weight])
    assert escaped.x[-1] == pytest.approx(SPEED, abs=STEP)
    assert escaped.x[-2] == pytest.approx(BUMP, rel=0.03)
    smoothed = predicted.prepared.base_structure.with_term(Term("stribeck", smooth, (0,)))
    solution = nonlinear_least_squares([predicted], smoothed, stuck.x, [weight])
    assert escape_local_minima([predicted], solution, [weight]) is solution


def test_two_parameters_of_the_same_effect_are_tried_together() -> None:
    recording = building.record(2)
    play = building.structure(recording, "backlash").terms[0]
    structure = replace(building.structure(recording), terms=(play, replace(play, name="other")))
    searched = np.array([entry.term >= 0 for entry in structure.parameters])
    tried = list(_neighbors(structure, searched))
    assert len(tried) == len({tuple(factors.items()) for factors in tried})
    assert {len(factors) for factors in tried} == {1, 2}
    for factors in tried:
        assert len({structure.parameters[entry].term for entry in factors}) == 1
        assert all(factor < 1 for factor in factors.values()) or all(factor > 1 for factor in factors.values())


def test_iteration_never_raises_the_loss() -> None:
    predicted, weight = predictor(building.record(extra=stribeck, noise=0.05))
    structure = building.structure(predicted.prepared.recording, "stribeck")
    for speed in (0.01, 0.1, 5.0):
        first = initial_solution([predicted], structure, np.array([0.0, 0.0, 0.0, 0.0, speed]), [weight])
        assert levenberg_marquardt([predicted], first, [weight]).loss <= first.loss


def test_nonlinear_parameters_stay_in_their_range() -> None:
    predicted, weight = predictor(building.record(noise=0.1))
    structure = building.structure(predicted.prepared.recording, "stribeck")
    speed = structure.parameters[-1]
    for start in (-3.0, 1e6):
        guess = np.array([0.0, 0.0, 0.0, 0.0, start])
        solution = nonlinear_least_squares([predicted], structure, guess, [weight])
        assert speed.lower <= solution.x[-1] <= speed.upper


def test_search_that_diverges_takes_no_step_along_what_is_too_large() -> None:
    ordinary = np.array([1.0, -1.0, 1.0, -1.0])
    rows = np.column_stack([ordinary, 1e200 * np.arange(1.0, 5.0)]), 3 * ordinary
    step = _solve(cast(Solution, SimpleNamespace(rows=lambda: rows)), np.array([True, True]))
    assert step == pytest.approx([3.0, 0.0])


def test_derivatives_are_those_of_the_predicted_torque() -> None:
    predicted, weight = predictor(building.record(extra=stribeck))
    structure = building.structure(predicted.prepared.recording, "stribeck")
    x = np.array([*building.parameters(), BUMP, SPEED])
    solution = initial_solution([predicted], structure, x, [weight])
    step = 1e-5
    for entry in range(len(x)):
        upper, lower = (predicted.torque(structure, solution.x + side * step * np.eye(5)[entry]) for side in (1, -1))
        difference, derivative = (upper - lower) / (2 * step), solution.derivatives[0][:, :, entry]
        known = np.isfinite(difference)
        np.testing.assert_allclose(derivative[known], difference[known], rtol=1e-3, atol=1e-3)


def test_recordings_are_fitted_together_and_unmeasured_rows_do_not_count() -> None:
    """The first recording is wrong, but its weights are zero in all rows but a few."""
    good, weight = predictor(building.record(noise=0.02, shape=1))
    bad, none = predictor(building.record(extra=lambda motion: 5.0 * motion.velocity))
    structure = building.structure(good.prepared.recording)
    solution = nonlinear_least_squares([bad, good], structure, np.zeros(3), [0.0 * none, weight])
    np.testing.assert_allclose(solution.x, building.parameters(), rtol=0.02)
    assert len(solution.rows()[1]) == int((weight > 0).sum())


def test_unit_of_the_torque_does_not_matter() -> None:
    recording, tenfold = (building.record(extra=stribeck, noise=0.05) for _ in range(2))
    assert tenfold.effort is not None
    tenfold.effort[:] *= 10.0
    results = []
    for made in (recording, tenfold):
        predicted, weight = predictor(made)
        structure = building.structure(made, "stribeck")
        guess = np.array([0.0, 0.0, 0.0, 0.0, 0.4])
        results.append(nonlinear_least_squares([predicted], structure, guess, [weight]).x)
    np.testing.assert_allclose(results[1], results[0] * [10, 10, 10, 10, 1], rtol=1e-3)


def test_model_does_not_improve_by_predicting_nothing() -> None:
    """A delay leaves rows beside gaps without a prediction; those count like the others."""
    recording = building.record(noise=0.1)
    assert recording.effort is not None
    recording.effort[::100] = np.nan
    predicted, weight = predictor(recording)
    structure = building.structure(predicted.prepared.recording)
    whole = nonlinear_least_squares([predicted], structure, np.zeros(3), [weight])
    residual = whole.residuals[0].copy()
    residual[::2] = np.nan
    assert replace(whole, residuals=(residual,)).loss == pytest.approx(whole.loss, rel=0.1)

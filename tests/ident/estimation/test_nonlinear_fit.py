"""Nonlinear least squares on recordings with known parameters."""

from dataclasses import replace

import numpy as np
import pytest

from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import (
    escape_local_minima,
    initial_solution,
    levenberg_marquardt,
    nonlinear_least_squares,
)
from ident.estimation.predicted_torque import TorquePredictor
from ident.estimation.shape_parameters import fit_shape_parameters
from recordings.recording import Floats, Recording
from tests.ident import building

BUMP, SPEED, STEP = 0.8, 0.6, 0.04


def stribeck(motion: Motion) -> Floats:
    bump: Floats = BUMP * np.exp(-((motion.velocity / SPEED) ** 2)) * motion.direction
    return bump


def predictor(recording: Recording) -> tuple[TorquePredictor, Floats]:
    prepared = building.prepared(recording)
    return TorquePredictor(prepared), np.where(prepared.usable, 1.0, 0.0)


def guess(speed: float) -> Floats:
    return np.array([0.0, 0.0, 0.0, 0.0, speed])


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
    solution = nonlinear_least_squares([predicted], structure, guess(start), [weight])
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
    stuck = nonlinear_least_squares([predicted], structure, guess(start), [weight])
    assert stuck.x[-1] == pytest.approx(start)
    escaped = escape_local_minima([predicted], stuck, [weight])
    assert escaped.x[-1] == pytest.approx(SPEED, abs=STEP)
    assert escaped.x[-2] == pytest.approx(BUMP, rel=0.03)
    smoothed = predicted.prepared.base_structure.with_term(Term("stribeck", smooth, (0,)))
    solution = nonlinear_least_squares([predicted], smoothed, stuck.x, [weight])
    assert escape_local_minima([predicted], solution, [weight]) is solution


@pytest.mark.parametrize("speed", [-3.0, 0.01, 0.1, 5.0, 1e6])
def test_iteration_never_raises_the_loss_nor_leaves_the_range(speed: float) -> None:
    predicted, weight = predictor(building.record(extra=stribeck, noise=0.05))
    structure = building.structure(predicted.prepared.recording, "stribeck")
    first = initial_solution([predicted], structure, guess(speed), [weight])
    solution = levenberg_marquardt([predicted], first, [weight])
    assert solution.loss <= first.loss
    assert structure.parameters[-1].lower <= solution.x[-1] <= structure.parameters[-1].upper


def test_recordings_are_fitted_together_and_unmeasured_rows_do_not_count() -> None:
    """The first recording is wrong, but its weights are zero in all rows but a few."""
    good, weight = predictor(building.record(noise=0.02, shape=1))
    bad, none = predictor(building.record(extra=lambda motion: 5.0 * motion.velocity))
    structure = building.structure(good.prepared.recording)
    solution = nonlinear_least_squares([bad, good], structure, np.zeros(3), [0.0 * none, weight])
    np.testing.assert_allclose(solution.x, building.parameters(), rtol=0.02)
    assert len(solution.rows()[1]) == int((weight > 0).sum())


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


def fitted(*names: str, **options: object) -> tuple[ModelStructure, Floats]:
    recording = building.record(**options)  # type: ignore[arg-type]
    return fit_shape_parameters([building.prepared(recording)], building.structure(recording, *names).terms)[:2]


def test_without_effects_it_is_the_mechanism() -> None:
    structure, x = fitted(joints=2)
    assert structure.terms == ()
    np.testing.assert_allclose(x, building.parameters(2), rtol=0.01)


@pytest.mark.parametrize("names", [("stribeck", "joint_spring"), ("joint_spring", "stribeck")])
def test_order_of_the_effects_does_not_matter(names: tuple[str, str]) -> None:
    structure, x = fitted(*names, extra=lambda motion: stribeck(motion) + 1.2 * motion.position, noise=0.01)
    values = dict(zip((entry.name for entry in structure.parameters), x, strict=True))
    assert values["stribeck.v_s"] == pytest.approx(0.6, rel=0.03)
    assert values["joint_spring.k1"] == pytest.approx(1.2, rel=0.03)

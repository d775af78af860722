"""Fit of the shape and signal parameters of effects that were chosen, before a linear estimator fits the others."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data.row_weights import FittedRows
from ident.dynamics.effects.base import Effect, Suggestion
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import Solution, levenberg_marquardt, nonlinear_least_squares
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats

_CONVERGED = 1e-6
"""Relative reduction of the loss below which steps are far smaller than the noise of tens of thousands of rows."""


def fit_shape_parameters(
    recordings: Sequence[PreparedRecording], terms: Sequence[Term], rows: FittedRows | None = None
) -> tuple[ModelStructure, Floats, FittedRows | None]:
    """Fit the shapes and signal parameters of the effects `terms` to the `recordings`, by nonlinear least squares.

    Returns the structure with all effects, its parameters (K,), and the `rows` with weights by what it leaves.

    The effects are added one by one. For each one, the fit starts from all of its initial guesses, and the best
    result is kept. All parameters are fitted together in each step.

    rows: those of the estimator that fits the others, with their weights: intervals are those of one fit of all
        parameters. None: all usable rows count alike.
    """
    predictors = [TorquePredictor(prepared) for prepared in recordings]
    weights = rows.fit_weights if rows else [np.where(prepared.usable, 1.0, 0.0) for prepared in recordings]
    bare = recordings[0].base_structure
    solution = nonlinear_least_squares(predictors, bare, np.zeros(len(bare.parameters)), weights)
    for term in terms:
        structure = solution.structure.with_term(term)
        suggested = suggestions(term.effect, predictors, solution, solution.residuals)
        candidates = [
            nonlinear_least_squares(predictors, structure, np.concatenate([solution.x, start]), weights)
            for start in _initial_guesses(
                term, term.shape_guesses(suggested), guess_scales(term, predictors[0], solution)
            )
        ]
        solution = min(candidates, key=lambda candidate: candidate.loss)
    if rows:
        rows = rows.reweighted(solution.residuals)
        weights = rows.fit_weights
        solution = nonlinear_least_squares(predictors, solution.structure, solution.x, weights)
    # A narrow valley, as of a mass and its place, takes more steps than a search among many models has.
    while (better := levenberg_marquardt(predictors, solution, weights)).loss < solution.loss * (1 - _CONVERGED):
        solution = better
    return solution.structure, solution.x, rows


def suggestions(
    effect: Effect, predictors: Sequence[TorquePredictor], solution: Solution, residuals: Sequence[Floats]
) -> list[Suggestion]:
    """Initial guesses that an `effect` beside the model of `solution` suggests from each recording of `predictors`.

    residuals: (m, dof) of each recording [N m], of which the rows that the solution was fitted to are used.
    """
    suggested: list[Suggestion] = []
    if effect.suggest is None:
        return suggested
    for predictor, weight, residual in zip(predictors, solution.weights, residuals, strict=True):
        inputs = predictor.effect_inputs(solution.structure, solution.x)
        masked = np.where(weight > 0, residual, np.nan)
        suggested += effect.suggest(inputs.decimated(predictor.prepared.preprocessed.decimation), masked)
    return suggested


def guess_scales(term: Term, predictor: TorquePredictor, solution: Solution) -> Floats:
    """Factors (instances, 1) of the initial guesses of a `term` beside the model of `solution`."""
    if term.effect.guess_scale is None:
        return np.ones((term.instances, 1))
    scale = term.effect.guess_scale(predictor.effect_inputs(solution.structure, solution.x))
    return scale[list(term.joints), None]


def _initial_guesses(term: Term, shapes: Sequence[Floats], scales: Floats) -> list[Floats]:
    """Vectors (local parameters + shapes,) from which the fit starts."""
    if term.effect.linear:
        local = [np.zeros(term.instances * len(term.local_parameters))]
    else:
        local = [
            (scales * values).ravel()
            for values in product(*(quantity.initial_guesses for quantity in term.local_parameters))
        ]
    return [np.concatenate(pair) for pair in product(local, shapes)]

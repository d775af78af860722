"""Fit of the shape and signal parameters of effects that were chosen, before a linear estimator fits the others."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Effect
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import nonlinear_least_squares
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats


def fit_shape_parameters(
    recordings: Sequence[PreparedRecording], terms: Sequence[Term]
) -> tuple[ModelStructure, Floats]:
    """Fit the shapes and signal parameters of the effects `terms` to the `recordings`, by nonlinear least squares.

    Returns the structure with all effects, and its parameters (K,).

    The effects are added one by one. For each one, the fit starts from all of its initial guesses, and the best
    result is kept. All parameters are fitted together in each step.
    """
    predictors = [TorquePredictor(prepared) for prepared in recordings]
    weights = [np.where(prepared.usable, 1.0, 0.0) for prepared in recordings]
    bare = recordings[0].base_structure
    solution = nonlinear_least_squares(predictors, bare, np.zeros(len(bare.parameters)), weights)
    for term in terms:
        structure = solution.structure.with_term(term)
        inputs = predictors[0].effect_inputs(solution.structure, solution.x)
        suggested = _suggested_shapes(term.effect, inputs, solution.residuals[0], recordings[0])
        candidates = [
            nonlinear_least_squares(predictors, structure, np.concatenate([solution.x, start]), weights)
            for start in _initial_guesses(term, suggested)
        ]
        solution = min(candidates, key=lambda candidate: candidate.loss)
    return solution.structure, solution.x


def _suggested_shapes(
    effect: Effect, inputs: EffectInputs, residual: Floats, prepared: PreparedRecording
) -> list[Floats]:
    if effect.suggest is None:
        return []
    suggestions = effect.suggest(inputs.decimated(prepared.preprocessed.decimation), residual)
    return [np.array([shapes[shape.name] for shape in effect.shapes]) for shapes in suggestions]


def _initial_guesses(term: Term, suggested: Sequence[Floats]) -> list[Floats]:
    """Vectors (local parameters + shapes,) from which the fit starts."""
    shapes = [np.array(values, float) for values in product(*(shape.initial_guesses for shape in term.effect.shapes))]
    shapes += suggested
    if isinstance(term.effect, Additive):
        local = [np.zeros(term.instances * len(term.local_parameters))]
    else:
        local = [
            np.tile(values, term.instances)
            for values in product(*(quantity.initial_guesses for quantity in term.local_parameters))
        ]
    return [np.concatenate(pair) for pair in product(local, shapes)]

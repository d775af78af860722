"""Ideas of the diagnosis that are one function each, and what that function would say if nobody had had the idea."""

from collections.abc import Callable
from typing import Any

import numpy as np

OFF: dict[str, Callable[..., Any]] = {
    "judge.fitted_model.FittedModel.improvement_in_turn": lambda *_: None,
    "judge.judge._shows_in_training": lambda *_: True,
    "judge.equivalence.is_preferred": lambda *_: False,
    "judge.indistinguishable.indistinguishable": lambda *_: (),
    "judge.price._prior": lambda model: 0.0,
    "judge.rules.mechanism._flipped_parameter": lambda *_: None,
    "judge.rules.shape._is_needed_at_limit": lambda *_: True,
    "ripple.ripple._is_known": lambda *_: False,
    "ripple.ripple_search._Pursuit._lasts": lambda *_: True,
    "ripple.vibration_check._differs": lambda *_: True,
    "search.best_first.BestFirst._contained": lambda *_: (),
    "search.best_first.BestFirst._smaller": lambda *_: (),
    "search.best_first.BestFirst._wider": lambda *_: (),
    "search.best_first._is_large": lambda *_: True,
    "search.best_first._is_possible": lambda *_: True,
    "search.best_first._leaves_much": lambda *_: False,
    "search.candidates.Candidates._on_possible_joints": lambda self, before: before,
    "search.review._is_redundant": lambda *_: False,
    "search.review._rivals": lambda *_: [],
    "search.screening._merge_guesses": lambda candidates: candidates[0],
    "search.search.Search._exchanged": lambda *_: (),
    "search.search.Search._with_curve": lambda *_: None,
    "split.noise_floor._clipped_mean_square": lambda x: np.ones(x.shape[1]),
    "split.noise_floor._drive_mean_square": lambda solution, predictor, *_: np.zeros(
        predictor.prepared.torque.shape[1]
    ),
    "split.noise_floor._encoder_mean_square": lambda solution, predictor, *_: np.zeros(
        predictor.prepared.torque.shape[1]
    ),
    "split.noise_floor._loop_amplification": lambda predictor, solution, expected, repeating: np.ones(len(repeating)),
    "split.observability._lacking": lambda *_: (),
    "split.split_data.SplitData.escape_local_minima": lambda self, before: before,
    "split.split_data.SplitData.unjudged": lambda self, *_: tuple(map(np.zeros_like, self.train)),
    "unknown.imitation._imitation": lambda selection, curves, given: None,
    "unknown.unexplained_residual._is_vibration": lambda *_: False,
}
"""By the place of the function below `ident/diagnosis`: what takes its place."""

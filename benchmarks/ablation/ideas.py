"""Ideas of the diagnosis that are one function each, and what that function would say if nobody had had the idea."""

from collections.abc import Callable
from typing import Any

import numpy as np


def _of_last(*arguments: Any) -> Any:
    return arguments[-1]


def _of_none(*arguments: Any) -> None:
    return None


def _yes(*arguments: Any) -> bool:
    return True


def _no(*arguments: Any) -> bool:
    return False


def _nothing(*arguments: Any) -> tuple[()]:
    return ()


def _none_each(split: Any, *arguments: Any) -> Any:
    return tuple(np.zeros_like(rows) for rows in split.train)


def _zero_each_joint(solution: Any, predictor: Any, *arguments: Any) -> Any:
    return np.zeros(predictor.prepared.torque.shape[1])


OFF: dict[str, Callable[..., Any]] = {
    "judge.fitted_model.FittedModel.improvement_in_turn": _of_none,
    "judge.judge._shows_in_training": _yes,
    "judge.equivalence.is_preferred": _no,
    "judge.indistinguishable.indistinguishable": _nothing,
    "judge.price._prior": lambda model: 0.0,
    "judge.rules.mechanism._flipped_parameter": _of_none,
    "judge.rules.mechanism._other_effect_impossible": _of_none,
    "judge.rules.shape._is_needed_at_limit": _yes,
    "ripple.ripple._is_known": _no,
    "ripple.ripple_search._Pursuit._lasts": _yes,
    "ripple.vibration_check._differs": _yes,
    "search.best_first.BestFirst._contained": _nothing,
    "search.best_first.BestFirst._smaller": _nothing,
    "search.best_first.BestFirst._wider": _nothing,
    "search.best_first._is_large": _yes,
    "search.best_first._is_possible": _yes,
    "search.best_first._leaves_much": _no,
    "search.candidates.Candidates._on_possible_joints": _of_last,
    "search.candidates.Candidates.searched_again": _of_last,
    "search.candidates._is_further_line": _no,
    "search.review._is_redundant": _no,
    "search.review._rivals": lambda *arguments: [],
    "search.screening._merge_guesses": lambda candidates: candidates[0],
    "search.search.Search._exchanged": _nothing,
    "search.search.Search._with_curve": _of_none,
    "split.noise_floor._clipped_mean_square": lambda x: np.ones(x.shape[1]),
    "split.noise_floor._drive_mean_square": _zero_each_joint,
    "split.noise_floor._encoder_mean_square": _zero_each_joint,
    "split.noise_floor._loop_amplification": lambda *arguments: np.ones(len(arguments[-1])),
    "split.observability._lacking": _nothing,
    "split.split_data.SplitData.escape_local_minima": _of_last,
    "split.split_data.SplitData.unjudged": _none_each,
    "unknown.imitation._beyond_own_motion": _yes,
    "unknown.imitation.remove_imitations": lambda search, selection, learned: (selection, learned),
    "unknown.unexplained_residual._is_vibration": _no,
}
"""By the place of the function below `ident/diagnosis`: what takes its place."""

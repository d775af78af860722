"""Particle swarm fit of the paper with progress reports; the same computation as `ident fit --method pso`."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from ident.diagnosis.unknown.residual_test import check_residual
from ident.dynamics.effects.library import library
from ident.estimation import estimators
from ident.identification import identify
from ident.workbench.worker.views import SwarmProgress, SwarmRequest, SwarmResult

METHOD = "pso"
_INTERVAL = 0.1
"""Minimum time between two progress reports [s]."""


def run_swarm(
    train: Path,
    validate: Path | None,
    request: SwarmRequest,
    effect_files: Sequence[Path],
    on_progress: Callable[[SwarmProgress], None],
) -> SwarmResult:
    """Fit the parameters by particle swarm; call `on_progress` while it searches.

    Raises:
        BadInput: a recording cannot be used, or the recordings come from different rigs.
    """
    settings = estimators.settings(METHOD, {})
    options = identify.FitOptions(
        METHOD,
        settings,
        request.seed,
        "parallel",
        request.cutoff,
        request.effects,
        library(effect_files),
        base_effects=True,
        without=request.without,
    )
    log = _ConvergenceLog(settings.iterations, settings.tolerance, on_progress)
    result = identify.identify([train], validate, options, log)
    test = check_residual(result.predictions, result.structure, result.parameters)
    return SwarmResult(result.model.model_copy(update={"residual_test": test}), log.progress)


class _ConvergenceLog:
    """Records the excess of every step and reports it at most once per `_INTERVAL`."""

    def __init__(self, max_steps: int, tolerance: float, on_progress: Callable[[SwarmProgress], None]) -> None:
        self._max_steps, self._tolerance, self._on_progress = max_steps, tolerance, on_progress
        self._excess: list[float] = []
        self._last_call = 0.0

    @property
    def progress(self) -> SwarmProgress:
        return SwarmProgress(tuple(self._excess), self._max_steps, self._tolerance)

    def __call__(self, done: int, total: int, excess: float | None = None, /) -> None:
        if excess is None:
            return
        self._excess.append(excess)
        now = time.monotonic()
        if now - self._last_call > _INTERVAL:
            self._last_call = now
            self._on_progress(self.progress)

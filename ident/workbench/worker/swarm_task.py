"""Particle swarm fit of the paper with progress reports; the same computation as `ident fit --method pso`."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path

from ident.diagnosis.unknown.residual_test import check_residual
from ident.dynamics.effects.base import Effect
from ident.estimation import estimators
from ident.identification import identify
from ident.workbench.worker.views import SwarmProgress, SwarmRequest, SwarmResult

_METHOD = "pso"
_INTERVAL = 0.1
"""Minimum time between two progress reports [s]."""


def run_swarm(
    train: Path,
    validate: Path | None,
    request: SwarmRequest,
    library: Mapping[str, Effect],
    on_progress: Callable[[SwarmProgress], None],
) -> SwarmResult:
    """Fit the parameters by particle swarm; call `on_progress` while it searches.

    Raises:
        BadInput: a recording cannot be used, or the recordings come from different rigs.
    """
    settings = estimators.settings(_METHOD, {})
    options = identify.FitOptions(
        _METHOD,
        settings,
        request.seed,
        "parallel",
        request.cutoff,
        request.effects,
        library,
        base_effects=True,
        without=request.without,
    )
    excesses: list[float] = []
    last_report = 0.0

    def progress() -> SwarmProgress:
        return SwarmProgress(tuple(excesses), settings.iterations, settings.tolerance)

    def log(done: int, total: int, excess: float | None = None, /) -> None:
        nonlocal last_report
        if excess is None:
            return
        excesses.append(excess)
        if time.monotonic() - last_report > _INTERVAL:
            last_report = time.monotonic()
            on_progress(progress())

    result = identify.identify([train], validate, options, log)
    test = check_residual(result.predictions, result.structure, result.parameters)
    return SwarmResult(result.model.model_copy(update={"residual_test": test}), progress())

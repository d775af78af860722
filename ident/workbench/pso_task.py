"""The paper's swarm, watched while it searches. It is what `ident fit` does, called with the same choices."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from ident.estimation import estimators
from ident.identification import identify
from ident.residuals.phases import failures
from ident.workbench.cli_equivalent import swarm_command
from ident.workbench.views import Chosen, Descent, Swarmed

METHOD = "pso"
_PAUSE = 0.1
"""Between two pictures of the search [s]."""


def found(
    train: Path,
    validate: Path | None,
    chosen: Chosen,
    effect_files: Sequence[Path],
    tell: Callable[[Descent], None],
) -> Swarmed:
    """Let the swarm find the parameters; `tell` is called while it searches.

    Raises:
        BadInput: a recording cannot be used, or they are not of the same rig.
    """
    settings = estimators.settings(METHOD, {})
    choices = identify.Choices(
        METHOD, settings, chosen.seed, "parallel", chosen.cutoff, chosen.effects, tuple(effect_files)
    )
    watch = _Watch(settings.iterations, settings.tolerance, tell)
    result = identify.identify([train], validate, choices, watch)
    command = swarm_command(chosen, train.name, validate.name if validate else None)
    return Swarmed(result.model, watch.descent, failures(result), command)


class _Watch:
    """Tells of the search, but not of every single step."""

    def __init__(self, total: int, goal: float, tell: Callable[[Descent], None]) -> None:
        self._total, self._goal, self._tell = total, goal, tell
        self._excess: list[float] = []
        self._last = 0.0

    @property
    def descent(self) -> Descent:
        return Descent(tuple(self._excess), self._total, self._goal)

    def __call__(self, done: int, total: int, excess: float | None = None, /) -> None:
        if excess is None:
            return
        self._excess.append(excess)
        now = time.monotonic()
        if now - self._last > _PAUSE:
            self._last = now
            self._tell(self.descent)

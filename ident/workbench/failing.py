"""Where the present model fails: what `ident compare` says of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ident import estimators, identification, prediction
from ident.compare import comparison
from ident.compare.comparison import Comparison
from ident.composition import Composition
from ident.effects import Effect
from ident.figures import spectrum, torque, where
from ident.workbench import plots
from ident.workbench.views import Failing
from recordings.recording import Floats


def failing(
    files: tuple[Path, Path | None],
    settled: tuple[Composition, Floats],
    bandwidth: float,
    library: Mapping[str, Effect],
) -> Failing:
    """The model fitted to the training recording, as `ident diagnose --apply` does it, on the other one."""
    train, validate = files
    choices = identification.Choices("ls", estimators.settings("ls", {}), 0, "parallel", bandwidth)
    model = identification.identify([train], validate, choices, _silent, settled).model
    found = comparison.compare(model, prediction.predict(model, [validate or train], library))
    return Failing(model, found.sentences, comparison.as_json(found), _figures(found))


def _figures(found: Comparison) -> dict[str, plots.Figure]:
    models = {"model": found}
    drawn = {
        "In which phase of the motion": where.phases(models),
        "Over what the residual depends on": where.curves(models),
        "At which frequency": spectrum.densities(models),
    }
    if found.windows:
        drawn["The worst stretches, closer"] = torque.worst(found)
    return {title: plots.plain(figure) for title, figure in drawn.items()}


def _silent(*progress: Any) -> None:
    """The page shows words, no steps."""

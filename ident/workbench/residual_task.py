"""Where the present model fails: what `ident compare` says of it."""

from collections.abc import Mapping
from pathlib import Path

from ident.diagnosis.split_data import Material
from ident.diagnosis.steps import State
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition
from ident.estimation import estimators
from ident.identification import identify, prediction
from ident.identification.model import Model
from ident.identification.prediction import Prediction
from ident.output.figures import residuals, spectrum, torque
from ident.residuals import analysis
from ident.residuals.analysis import Comparison
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
    choices = identify.Choices("ls", estimators.settings("ls", {}), 0, "parallel", bandwidth)
    model = identify.identify([train], validate, choices, lambda *_: None, settled).model
    return _told(model, analysis.compare(model, prediction.predict(model, [validate or train], library)))


def of_excerpts(material: Material, state: State) -> Failing:
    """The model as the ladder has it, on those parts of long recordings that the ladder looks at."""
    chosen = [i for i, held in enumerate(material.held) if held.any() or not material.other_motion]
    predictions = [Prediction(material.datasets[i], material.datasets[i].torque - state.residuals[i]) for i in chosen]
    return _told(None, analysis.compare(None, predictions))


def _told(model: Model | None, found: Comparison) -> Failing:
    return Failing(
        model=model,
        recordings=tuple(dict.fromkeys(one.dataset.recording.path.name for one in found.predictions)),
        unit=found.joints[0].unit,
        sentences=found.sentences,
        windows=found.windows,
        figures=_figures(found),
    )


def _figures(found: Comparison) -> dict[str, plots.Figure]:
    models = {"model": found}
    drawn = {
        "In which phase of the motion": residuals.phases(models),
        "Over what the residual depends on": residuals.curves(models),
        "At which frequency": spectrum.densities(models),
    }
    if found.windows:
        drawn["The worst stretches, closer"] = torque.worst(found)
    return {title: plots.plain(figure) for title, figure in drawn.items()}

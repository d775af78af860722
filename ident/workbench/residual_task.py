"""Residual analysis of the current model, as in `ident compare`."""

from collections.abc import Mapping
from pathlib import Path

from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import FittedModel
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure
from ident.estimation import estimators
from ident.identification import identify, prediction
from ident.identification.model import Model
from ident.identification.prediction import Prediction
from ident.output.figures import residuals, spectrum, torque
from ident.residuals import analysis
from ident.residuals.analysis import Comparison
from ident.workbench import plots
from ident.workbench.views import ResidualView
from recordings.recording import Floats


def residual_view(
    files: tuple[Path, Path | None],
    solution: tuple[ModelStructure, Floats],
    bandwidth: float,
    library: Mapping[str, Effect],
) -> ResidualView:
    """Fit the model to the training recording, as `ident diagnose --apply` does; analyse it on the validation recording."""
    train, validate = files
    choices = identify.Choices("ls", estimators.settings("ls", {}), 0, "parallel", bandwidth)
    model = identify.identify([train], validate, choices, lambda *_: None, solution).model
    return _view(model, analysis.compare(model, prediction.predict(model, [validate or train], library)))


def residual_view_of_excerpts(material: SplitData, state: FittedModel) -> ResidualView:
    """Analyse the model of the ladder on the excerpts of long recordings that the ladder uses."""
    chosen = [i for i, held in enumerate(material.test) if held.any() or not material.other_motion]
    predictions = [Prediction(material.datasets[i], material.datasets[i].torque - state.residuals[i]) for i in chosen]
    return _view(None, analysis.compare(None, predictions))


def _view(model: Model | None, analysed: Comparison) -> ResidualView:
    return ResidualView(
        model=model,
        recordings=tuple(dict.fromkeys(one.dataset.recording.path.name for one in analysed.predictions)),
        unit=analysed.joints[0].unit,
        sentences=analysed.sentences,
        windows=analysed.windows,
        figures=_figures(analysed),
    )


def _figures(analysed: Comparison) -> dict[str, plots.Figure]:
    models = {"model": analysed}
    drawn = {
        "Residual by motion phase": residuals.phases(models),
        "Residual over the quantities that it depends on": residuals.curves(models),
        "Residual by frequency": spectrum.densities(models),
    }
    if analysed.windows:
        drawn["Worst intervals in detail"] = torque.worst_windows(analysed)
    return {title: plots.to_dict(figure) for title, figure in drawn.items()}

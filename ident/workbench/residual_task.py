"""Residual analysis of the current model, as in `ident compare`."""

from collections.abc import Mapping
from pathlib import Path

from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import FittedModel
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure
from ident.estimation import estimators
from ident.identification import identify, prediction
from ident.identification.model_file import ModelFile
from ident.output.figures import residuals, spectrum, torque
from ident.residuals import analysis
from ident.residuals.analysis import ResidualAnalysis
from ident.workbench import plots
from ident.workbench.views import ResidualView
from recordings.recording import Floats


def residual_view(
    files: tuple[Path, Path | None],
    solution: tuple[ModelStructure, Floats],
    bandwidth: float,
    library: Mapping[str, Effect],
) -> ResidualView:
    """Fit the model to the training recording, as `ident diagnose --apply`, and analyse the validation residual."""
    train, validate = files
    options = identify.FitOptions("ls", estimators.settings("ls", {}), 0, "parallel", bandwidth)
    model = identify.identify([train], validate, options, lambda *_: None, solution).model
    return _residual_view(model, analysis.analyse(model, prediction.predict(model, [validate or train], library)))


def residual_view_of_excerpts(split: SplitData, model: FittedModel) -> ResidualView:
    """Analyse the model of the ladder on the excerpts of long recordings that the ladder uses."""
    indices = [i for i, test in enumerate(split.test) if test.any() or not split.other_motion]
    return _residual_view(None, analysis.analyse(None, [model.predictions[i] for i in indices]))


def _residual_view(model: ModelFile | None, analysed: ResidualAnalysis) -> ResidualView:
    models = {"model": analysed}
    figures = {
        "Residual by motion phase": residuals.phases(models),
        "Residual over the quantities that it depends on": residuals.curves(models),
        "Residual by frequency": spectrum.densities(models),
    }
    if analysed.windows:
        figures["Worst intervals in detail"] = torque.worst_windows(analysed)
    return ResidualView(
        model=model,
        recordings=tuple(dict.fromkeys(item.prepared.recording.path.name for item in analysed.predictions)),
        unit=analysed.joints[0].unit,
        sentences=analysed.sentences,
        windows=analysed.windows,
        figures={title: plots.to_dict(figure) for title, figure in figures.items()},
    )

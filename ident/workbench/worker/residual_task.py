"""Residual analysis of the current model, as in `ident compare`."""

from dataclasses import replace

from ident.diagnosis.document.result import model_file
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.unknown.unexplained_residual import UnexplainedResidual, estimate_unexplained
from ident.identification.model import Model
from ident.identification.prediction import Prediction
from ident.output.figures import residuals, spectrum, torque
from ident.output.report.sections import causes
from ident.output.tables import residuals as tables
from ident.residuals import analysis
from ident.workbench.figure import to_dict
from ident.workbench.worker.views import ResidualView


def residual_view(model: FittedModel, unexplained: UnexplainedResidual | None = None) -> ResidualView:
    """Analyse the residual of `model` on the validation recording, or else on the training recording.

    unexplained: its residual above the noise floor as the full diagnosis says; None: there was none, it is estimated.
    """
    file = model_file(model, unexplained or estimate_unexplained(model), diagnosed=unexplained is not None)
    split = model.split
    shown = [i for i, rows in enumerate(split.test) if rows.any() or not split.other_motion]
    predictions = [Prediction(split.recordings[i], model.computed[i], split.scored[i]) for i in shown]
    analysed = analysis.analyse(file, predictions, file.residual_test)
    models = {"model": analysed}
    figures = {
        "Residual by motion phase": residuals.phases(models),
        "Residual over the quantities that it depends on": residuals.curves(models),
        "Residual by frequency": spectrum.densities(models),
    }
    if analysed.windows:
        figures["Worst intervals in detail"] = torque.worst_windows(analysed)
    effects = {term.name: term.effect for term in model.solution.structure.terms}
    text, plot, table = causes.torque_by_cause(Model(file, effects), predictions[0].prepared)
    return ResidualView(
        model=file,
        recordings=tuple(dict.fromkeys(item.prepared.recording.path.name for item in analysed.predictions)),
        sentences=analysed.sentences,
        windows=analysed.windows,
        window_table=tables.windows(analysed),
        figures={title: to_dict(figure) for title, figure in figures.items()},
        causes=replace(table, caption=f"{plot.caption} {table.caption}"),
        causes_sentences=text.lines,
        causes_figure=to_dict(plot.figure),
    )

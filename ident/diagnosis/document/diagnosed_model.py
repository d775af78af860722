"""The model file of a model of the stepwise selection: the same values, intervals and errors as in the document."""

from dataclasses import replace

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.parameter_intervals import with_gain
from ident.diagnosis.unknown.residual_test import residual_test
from ident.diagnosis.unknown.unexplained_residual import UnexplainedResidual
from ident.estimation.linear_fit import Fit, search_region
from ident.estimation.problem import Estimate
from ident.estimation.regression import Regression, linearize
from ident.identification.identify import agreement, is_relative, model_of
from ident.identification.model_file import Agreement, FitMethod, ModelFile
from ident.identification.prediction import searched_parameters
from ident.uncertainty.assessment import assess, gain_uncertainty, interval_or_none
from ident.uncertainty.sensitivity import Sensitivity
from recordings.recording import Bools, Floats

METHOD = "wls"
"""The estimator that a diagnosis uses: least squares, weighted by the noise."""


def model_file(model: FittedModel, unexplained: UnexplainedResidual, diagnosed: bool = True) -> ModelFile:
    """Describe `model` with its `unexplained` residual as a file.

    diagnosed: whether a diagnosis has searched that residual for effects.
    """
    split, solution = model.split, model.solution
    structure, x = solution.structure, solution.x
    regressions = [linearize(split.recordings[i], structure, x) for i in split.train_indices]
    prepared, fit, linear = regressions[0].prepared, _fit(model, regressions), structure.linear
    relative = is_relative(prepared.recording)
    assessment, single = assess(regressions, fit, structure, METHOD, Sensitivity(None, ()), relative)
    # The model's own intervals also hold what quantization does to parameters, and the errors of what was searched.
    totals, shapes = parameter_intervals(model)
    own = [
        {
            "ci95": interval_or_none(total),
            "shape_ci95": interval_or_none(shape),
            "std": std,
            "degrees_of_freedom": None,
        }
        for total, shape, std in zip(
            totals[linear], shapes[linear], _known(model.uncertainty.std[linear]), strict=True
        )
    ]
    correlation = tuple(map(_known, model.uncertainty.correlation[np.ix_(linear, linear)]))
    file = model_of(
        regressions,
        structure,
        x,
        fit,
        FitMethod(
            name=METHOD,
            settings={},
            seed=0,
            objective=solution.loss,
            rows=solution.row_count,
            diagnostics={"selection": "ident diagnose"},
        ),
        prepared.method,
        (
            assessment.model_copy(update={"correlation": correlation}),
            [each.model_copy(update=update) for each, update in zip(single, own, strict=True)],
        ),
        (_agreement(model, split.train), _agreement(model, split.test)),
    )
    update = {
        "searched": searched_parameters(structure, x, shapes),
        "residual_test": residual_test(model, unexplained, diagnosed),
    }
    return file.model_copy(update=update)


def parameter_intervals(model: FittedModel) -> tuple[Floats, Floats]:
    """(K, 2) 95 % intervals of the parameters of `model`: with the uncertainty of the gain, and for a known gain."""
    recording, shapes = model.split.recordings[0].recording, model.shape_intervals
    totals = shapes if is_relative(recording) else with_gain(shapes, model.solution, gain_uncertainty(recording))
    return totals, shapes


def _fit(model: FittedModel, regressions: list[Regression]) -> Fit:
    """The linear parameters, as if a linear estimator had found them."""
    structure = model.solution.structure
    values = model.solution.x[structure.linear]
    rows, torques = zip(*(regression.rows() for regression in regressions), strict=True)
    bounds = search_region(structure.linear_parameters, np.concatenate(rows), np.concatenate(torques))
    estimate = Estimate(values, model.solution.loss, np.array([model.solution.loss]))
    return Fit(estimate, bounds, model.solution.row_count)


def _known(values: Floats) -> tuple[float | None, ...]:
    """The `values` (k,); None where they are not known."""
    return tuple(value if np.isfinite(value) else None for value in values.tolist())


def _agreement(model: FittedModel, rows: tuple[Bools, ...]) -> Agreement:
    """Agreement of `model` on `rows` (m, dof) of each recording."""
    used = [i for i, selected in enumerate(rows) if selected.any()]
    recordings: list[PreparedRecording] = [model.split.recordings[i] for i in used]
    measured = [np.where(rows[i], prepared.torque, np.nan) for i, prepared in zip(used, recordings, strict=True)]
    return agreement(recordings, measured, [model.computed[i] for i in used])


def with_errors(file: ModelFile, train: tuple[float, ...], validate: tuple[float, ...]) -> ModelFile:
    """The `file` with the RMS errors that a document states, which may reach above the low-pass."""
    assert file.validate_ is not None
    agreements = {
        "train": file.train.model_copy(update={"fitted": replace(file.train.fitted, rms=train)}),
        "validate_": file.validate_.model_copy(update={"fitted": replace(file.validate_.fitted, rms=validate)}),
    }
    return file.model_copy(update=agreements)

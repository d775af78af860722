"""Test a model's residual against the noise floor: the one verdict of fit, compare, diagnose, report and workbench.

The noise floor is that of `ident.diagnosis.split.noise_floor`, the rows are those in which a joint moves, and the
test is that of `ident.diagnosis.unknown.unexplained_residual`, for every model alike.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ident.data.excerpts import excerpts
from ident.data.prepared_recording import prepare
from ident.data.row_weights import moving_or_all, standstill_share
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.train_test_split import split_recordings
from ident.diagnosis.unknown.unexplained_residual import UnexplainedResidual, estimate_unexplained
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure
from ident.estimation import chunks
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.problem import Progress
from ident.identification.identify import FitOptions, identify
from ident.identification.model import Model
from ident.identification.model_file import FloorVerdict, ModelFile, RecordingSource, ResidualTest, recording_source
from ident.identification.prediction import Prediction, structure_of
from recordings.errors import BadInput, expect
from recordings.reader import Source
from recordings.recording import Bools, Floats, Recording


def residual_test(model: FittedModel, unexplained: UnexplainedResidual, diagnosed: bool = False) -> ResidualTest:
    """The test of `model` with its `unexplained` residual; `diagnosed`: a diagnosis has searched it for effects."""
    split, floor = model.split, model.noise_floor
    verdict: FloorVerdict = "above-noise" if unexplained.significant else "within-noise"
    return ResidualTest(
        verdict=verdict,
        diagnosed=diagnosed,
        bandwidth_hz=split.recordings[0].bandwidth,
        noise_rms=tuple(floor.rms.tolist()),
        repetition_rms=tuple(floor.noise.tolist()),
        quantization_rms=tuple(floor.quantization.tolist()),
        structured_rms=tuple(unexplained.rms.tolist()),
        structured_share=unexplained.share,
        recordings=_sources([data.recording for data in split.recordings]),
    )


def scored_predictions(
    model: ModelFile, predictions: Sequence[Prediction], library: Mapping[str, Effect]
) -> tuple[tuple[Prediction, ...], ResidualTest | None]:
    """The `predictions` of `model` with the rows that are scored, and the test of the residual in them.

    The test is the one that the model file holds, if it was done on these recordings. Alternative forms of the
    mechanism are not tested, and all of their rows are scored.
    """
    if model.form:
        return tuple(predictions), None
    structure, x = structure_of(model, predictions[0].prepared.recording.rig, library)
    held, sources = model.residual_test, _sources([prediction.prepared.recording for prediction in predictions])
    known = held is not None and set(sources) <= set(held.recordings)
    test = held if known else check_residual(predictions, structure, x)
    return score(predictions, structure, x, test), test


def fit_and_test(
    files: Sequence[Source], validate: Sequence[Source], options: FitOptions, progress: Progress
) -> Model:
    """Fit a model, see `ident.fit`, and test its residual against the noise floor.

    Raises:
        BadInput: several recordings are to `validate`, or as `identify`.
    """
    if len(validate) > 1:
        raise BadInput(f"validate: one recording expected, {len(validate)} found; leave the others out")
    expect(Callable, "a function", progress=progress)  # type: ignore[arg-type]
    result = identify(files, validate[0] if validate else None, options, progress)
    test = None if result.model.form else check_residual(result.predictions, result.structure, result.parameters)
    return Model(result.model.model_copy(update={"residual_test": test}), options.library, result)


def score(
    predictions: Sequence[Prediction], structure: ModelStructure, x: Floats, test: ResidualTest | None
) -> tuple[Prediction, ...]:
    """The `predictions` of a model with the rows that are scored: those in motion, and not near saturation."""
    rows: Sequence[Bools] = [_moving(prediction) for prediction in predictions]
    long = any(len(excerpts(prediction.prepared.recording)) > 1 for prediction in predictions)
    if test and not long and (model := _as_fitted(predictions, structure, x)):
        floor = np.array([value or 0.0 for value in test.noise_rms])
        held_out = replace(model.split, test=model.split.train)  # nothing is fitted
        rows = held_out.judged(model.solution, floor).test
    return tuple(replace(each, scored=moving) for each, moving in zip(predictions, rows, strict=True))


def check_residual(predictions: Sequence[Prediction], structure: ModelStructure, x: Floats) -> ResidualTest | None:
    """The test of a model `structure` with the parameters `x` (K,); None if the joints hardly move.

    Of long recordings, excerpts are tested.
    """
    model = _as_fitted([part for each in predictions for part in _excerpts(each, structure, x)], structure, x)
    return residual_test(model, estimate_unexplained(model, ())) if model else None


def _excerpts(prediction: Prediction, structure: ModelStructure, x: Floats) -> list[Prediction]:
    prepared, parts = prediction.prepared, excerpts(prediction.prepared.recording)
    if len(parts) == 1:
        return [prediction]
    short = [prepare(part.recording, prepared.method, prepared.cutoff, part.start, part.end) for part in parts]
    return [Prediction(each, chunks.torque(each, structure, x)) for each in short]


def _as_fitted(predictions: Sequence[Prediction], structure: ModelStructure, x: Floats) -> FittedModel | None:
    """The model as if it had been fitted to all rows in motion; None if there are too few.

    Its derivatives are not needed.
    """
    try:
        split = split_recordings([each.prepared for each in predictions], [])
    except BadInput:
        return None
    moving = tuple(map(_moving, predictions))
    residuals, count = tuple(each.residual for each in predictions), sum(int(rows.sum()) for rows in moving)
    split = replace(split, train=moving, test=tuple(np.zeros_like(rows) for rows in moving))
    return FittedModel(split, Solution(structure, x, residuals, (), split.weights, count))


def _moving(prediction: Prediction) -> Bools:
    """(m, dof) rows in which a joint moves; all usable ones of a joint that never does."""
    return moving_or_all(prediction.prepared, standstill_share(prediction.prepared))


def _sources(recordings: Sequence[Recording]) -> tuple[RecordingSource, ...]:
    return tuple(map(recording_source, {recording.path: recording for recording in recordings}.values()))

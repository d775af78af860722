"""Test a model's residual against the noise floor: the one verdict of fit, compare, diagnose, report and workbench.

The noise floor is that of `ident.diagnosis.split.noise_floor`, the rows are those in which a joint moves: for every
model alike. What is above the floor is structured, and may depend on the motion.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.basics.statistics import least_squares
from ident.data import cycle_statistics
from ident.data.excerpts import excerpts
from ident.data.prepared_recording import prepare
from ident.data.row_weights import moving_or_all, standstill_share
from ident.data.trends import SIGNIFICANT
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE
from ident.diagnosis.ripple.waves import Vibration, wave
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE
from ident.diagnosis.split.split_data import rms as rms_of
from ident.diagnosis.split.train_test_split import split_recordings
from ident.diagnosis.unknown.residual_dependence import ResidualDependence, find_dependences
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.travel_curve import TRAVEL
from ident.dynamics.structure import ModelStructure
from ident.estimation import chunks
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.problem import Progress
from ident.identification.fit_warnings import with_warnings
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.identification.identify import FitOptions, Identification, identify
from ident.identification.model import Model
from ident.identification.model_file import FloorVerdict, ModelFile, RecordingSource, ResidualTest, recording_source
from ident.identification.prediction import Prediction, structure_of
from ident.uncertainty.fit_warning import FitWarning
from recordings.errors import BadInput, expect
from recordings.reader import Source
from recordings.recording import Bools, Floats, Recording


@dataclass(frozen=True, eq=False)
class UnexplainedResidual:
    """The structured residual of one model."""

    rms: Floats
    """(dof,) RMS of the structured part [N m]."""
    share: float
    """Structured share of the mean square of the residual, over all joints."""
    significant: bool
    """Whether the structured part is relevant."""
    variables: tuple[str, ...]
    """Variables on which it depends."""
    sentence: str
    joints: tuple[int, ...]
    """Joints (from 0) in which it is searched: those where it is large and no vibration."""
    dependences: tuple[ResidualDependence, ...]
    """Curves that explain a part of it."""


def estimate_unexplained(
    model: FittedModel, known: Sequence[ResidualDependence] | None = None
) -> UnexplainedResidual:
    """The residual of `model` above its noise floor.

    known: its dependences, if known; None: they are searched, joint by joint.
    """
    split, residuals, floor = model.split, model.residuals, model.noise_floor
    total = rms_of(residuals, split.scored)
    structured = np.sqrt(np.maximum(total**2 - floor.rms**2, 0.0))
    repeats = total > floor.limit
    # Where the motion repeats, a structured residual does so, too; otherwise, more than noise is structure.
    if statistics := cycle_statistics.of_residuals(split.recordings, residuals, split.floor_rows):
        repeats &= np.array([each.repeating_p for each in statistics]) < SIGNIFICANT
    vibrates = np.array([_is_vibration(model, joint) for joint in range(len(total))])
    drifts = np.sqrt([max(trend.mean_square, 0.0) if trend else 0.0 for trend in floor.trends]) > floor.least
    relative = structured / split.torque_rms
    # A missing effect of one joint spreads to the others through shared parameters.
    large = relative**2 >= MIN_SHARE * (relative**2).max()
    searched = (repeats & large & ~vibrates) | drifts
    if known is None:
        known = find_dependences(split, model.solution, residuals, np.flatnonzero(searched).tolist())
    variables = {variable for dependence in known for variable in dependence.variables}
    variables |= ({"time"} if drifts.any() else set()) | ({"frequency"} if vibrates.any() else set())
    clauses = [
        f"joint {each.joint + 1}: {each.explained:.0%} of it depends on {' and '.join(each.variables)}"
        for each in known
    ]
    for joint, (line, trend) in enumerate(zip(floor.lines, floor.trends, strict=True)):
        if line and vibrates[joint]:
            clauses.append(_vibration(joint, line.frequency))
        if trend and drifts[joint]:
            kind = "from cycle to cycle" if trend.pattern == "linear" else f"at one instant ({trend.pattern})"
            clauses.append(f"joint {joint + 1}: it changes {kind}")
    what = "it repeats with the motion" if floor.source == "repetition" else "it exceeds the noise"
    significant = bool((repeats | vibrates | drifts).any())
    sentence = "; ".join(clauses or [f"{what}, but depends on no single variable"]) + "."
    return UnexplainedResidual(
        structured,
        float((structured**2).sum() / (total**2).sum()) if total.any() else 0.0,
        significant,
        tuple(sorted(variables)),
        sentence if significant else "only noise and encoder quantization.",
        tuple(np.flatnonzero(searched).tolist()),
        tuple(known),
    )


def with_vibrations(
    unexplained: UnexplainedResidual, vibrations: Sequence[Vibration], torque_rms: Floats
) -> UnexplainedResidual:
    """Add relevant `vibrations` above the low-pass, which are as unexplained as those below it.

    Its RMS and its share are still those of the residual below the low-pass. torque_rms: (dof,) [N m].
    """
    clauses = [
        _vibration(each.joint, each.frequency)
        for each in vibrations
        if each.amplitude / np.sqrt(2) > MIN_TORQUE_SHARE * torque_rms[each.joint]
    ]
    if not clauses:
        return unexplained
    known = [unexplained.sentence.removesuffix(".")] if unexplained.significant else []
    return replace(
        unexplained,
        significant=True,
        variables=tuple(sorted({*unexplained.variables, "frequency"})),
        sentence="; ".join([*known, *clauses]) + ".",
    )


def _vibration(joint: int, frequency: float) -> str:
    return f"joint {joint + 1}: a vibration of {frequency:.2f} Hz"


def _is_vibration(model: FittedModel, joint: int) -> bool:
    """Whether the line in the residual of a `joint` is relevant, and no frequency of the motion itself."""
    line = model.noise_floor.lines[joint]
    if line is None or line.mean_square < model.noise_floor.least[joint] ** 2:
        return False
    if model.noise_floor.source == "repetition":  # it differs between repetitions: it is none of the motion
        return True
    for recording, computed in zip(model.split.recordings, model.computed, strict=True):
        known = np.isfinite(computed[:, joint])
        signal = computed[known, joint] - computed[known, joint].mean()
        of_line = least_squares(wave(recording.time[known], 2 * np.pi * line.frequency), signal)
        if of_line @ of_line / 2 > line.mean_square:
            return False
    return True


def residual_test(model: FittedModel, unexplained: UnexplainedResidual, diagnosed: bool = False) -> ResidualTest:
    """The test of `model` with its `unexplained` residual; `diagnosed`: a diagnosis has searched it for effects."""
    split, floor = model.split, model.noise_floor
    recordings = [data.recording for data in split.recordings]
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
        missing=int(sum(gaps.max() for gaps in {each.path: each.gaps for each in recordings}.values())),
        recordings=recording_sources(recordings),
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
    held, recordings = model.residual_test, [each.prepared.recording for each in predictions]
    known = held is not None and set(recording_sources(recordings)) <= set(held.recordings)
    test = held if known else check_residual(predictions, structure, x)
    return score(predictions, structure, x, test), test


def fit_and_test(
    files: Sequence[Source], validate: Sequence[Source], options: FitOptions, progress: Progress
) -> Model:
    """Fit a model, see `ident.fit`, and test its residual against the noise floor.

    Raises:
        BadInput: as `identify`.
    """
    expect(Callable, "a function", progress=progress)  # type: ignore[arg-type]
    result = identify(files, validate, options, progress)
    test = None if result.model.form else check_residual(result.predictions, result.structure, result.parameters)
    model = with_warnings(_of_scored_rows(result, test), *_beyond_travel(result))
    return Model(model, options.library, result, result.train[0].prepared.recording)


def _of_scored_rows(result: Identification, test: ResidualTest | None) -> ModelFile:
    """The model of `result` with its `test`, and with RMS errors and R² of the scored rows, as all say them."""
    model = result.model.model_copy(update={"residual_test": test})
    if model.form:
        return model
    scored = score(result.predictions, result.structure, result.parameters, test)
    count, changes = len(result.train), {}
    for name, stated, parts in (
        ("train", model.train, scored[:count]),
        ("validate_", model.validate_, scored[count:]),
    ):
        if stated is not None:
            residual = np.concatenate([each.scored_residual for each in parts])
            torque = np.concatenate([each.prepared.torque for each in parts])
            fit = goodness_of_fit(torque, torque - residual)
            changes[name] = stated.model_copy(update={"fitted": replace(stated.fitted, rms=fit.rms, r2=fit.r2)})
    return model.model_copy(update=changes)


def _beyond_travel(result: Identification) -> Iterator[FitWarning]:
    """Yield how many of the held-out rows are not scored, because a curve is not known there."""
    held_out = result.predictions[len(result.train) :]
    if result.model.form or not held_out:
        return
    known, moving = (
        np.sum([rows(each).sum(axis=0) for each in held_out], axis=0)
        for rows in (lambda each: _known(each, result.structure, result.parameters), _moving)
    )
    shares = [f"{share:.1%} (joint {joint})" for joint, share in enumerate(1 - known / moving, start=1) if share > 0]
    if shares:
        curves = " and ".join(term.name for term in result.structure.terms if term.effect.curve)
        yield FitWarning(
            "held-out",
            True,
            f"Of the held-out rows, {' and '.join(shares)} are not scored: {curves} is not known outside of the "
            "travel in training.",
            kind="held-out",
        )


def score(
    predictions: Sequence[Prediction], structure: ModelStructure, x: Floats, test: ResidualTest | None
) -> tuple[Prediction, ...]:
    """The `predictions` of a model with the rows that are scored: those in motion, where the model says something."""
    rows: Sequence[Bools] = [_known(prediction, structure, x) for prediction in predictions]
    long = any(len(excerpts(prediction.prepared.recording)) > 1 for prediction in predictions)
    if test and not long and (model := _as_fitted(predictions, structure, x)):
        floor = np.array([value or 0.0 for value in test.noise_rms])
        rows = replace(model.split, test=model.split.train).judged(model.solution, floor).test  # nothing is fitted
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
    moving = tuple(_known(prediction, structure, x) for prediction in predictions)
    residuals, count = tuple(each.residual for each in predictions), sum(int(rows.sum()) for rows in moving)
    split = replace(split, train=moving, test=tuple(np.zeros_like(rows) for rows in moving))
    return FittedModel(split, Solution(structure, x, residuals, (), split.weights, count))


def _moving(prediction: Prediction) -> Bools:
    """(m, dof) rows in which a joint moves; all usable ones of a joint that never does."""
    return moving_or_all(prediction.prepared, standstill_share(prediction.prepared))


def _known(prediction: Prediction, structure: ModelStructure, x: Floats) -> Bools:
    """(m, dof) rows in which a joint moves within the travel that the curves of the model are known for.

    All rows in motion of a joint that hardly comes there.
    """
    rows = _moving(prediction)
    inside = rows.copy()
    for index, term in enumerate(structure.terms):
        if [quantity.name for quantity in term.effect.shapes] == list(TRAVEL):
            low, high = structure.shape_values(index, x).reshape(-1, len(TRAVEL)).T
            position = prediction.prepared.motion.position[:, term.joints]
            inside[:, term.joints] &= (low <= position) & (position <= high)
    return np.where(inside.sum(axis=0) >= prediction.prepared.regressor.shape[2], inside, rows)


def recording_sources(recordings: Sequence[Recording]) -> tuple[RecordingSource, ...]:
    """The files of `recordings`, each once: a long one is analysed in excerpts."""
    return tuple(map(recording_source, {recording.path: recording for recording in recordings}.values()))

"""From recordings to a judged model: read, preprocess, fit, compare with what the fit did and did not see."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ident.data.compatibility import check_no_overlap, check_same_rig
from ident.data.cutoff import Cutoff
from ident.data.dataset import Dataset, build_all
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data.samples import holds_torque
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.structure import ModelStructure
from ident.estimation import estimators
from ident.estimation.linear_fit import Fit, fit
from ident.estimation.linearized_model import LinearizedModel, fit_shape_parameters, parse_terms
from ident.estimation.problem import Progress
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.identification.model import (
    Agreement,
    CertifiedMinimum,
    FittedParameter,
    JointDelay,
    JointGoodnessOfFit,
    FitMethod,
    Model,
    Preprocessing,
    recording_source,
)
from ident.identification.prediction import effect_terms
from ident.uncertainty.assessment import ParameterUncertainty, assess
from ident.uncertainty.covariance import IntervalMethod
from ident.uncertainty.sensitivity import Sensitivity, sensitivity
from ident.uncertainty.time_delay import delays
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording


@dataclass(frozen=True)
class FitOptions:
    """What the user chose."""

    method: str
    settings: Any
    """The estimator's."""
    seed: int
    preprocessing: str
    cutoff: float | None
    """[Hz], or the preprocessing's own."""
    effects: tuple[str, ...] = ()
    """Added to the mechanism: NAME, or NAME:1,3 for some joints."""
    effect_files: tuple[Path, ...] = ()
    """Effects of the user's own."""
    physical: bool = False
    """Friction must oppose motion."""
    intervals: IntervalMethod = "stationary"
    """See `ident.uncertainty.covariance`."""


@dataclass(frozen=True, eq=False)
class Identification:
    """A fitted model with the data behind it."""

    model: Model
    mechanism: Mechanism
    fit: Fit
    train: tuple[Dataset, ...]
    validation: Dataset | None


def identify(
    files: Sequence[Path],
    validate: Path | None,
    options: FitOptions,
    progress: Progress,
    known_structure: tuple[ModelStructure, Floats] | None = None,
) -> Identification:
    """Fit the mechanism of the rig to the recordings `files` together, and judge it on them and on `validate`.

    settled: a composition whose shapes and distortions are known, with its parameters, in place of effects chosen.

    Raises:
        BadInput: a recording cannot be used, is in another one, or they are not of the same rig.
    """
    recordings = [read(path) for path in (*files, *([validate] if validate else []))]
    rig = recordings[0].rig
    check_same_rig(recordings)
    check_no_overlap(recordings)
    form = estimators.form(options.method)
    mechanism, datasets = _prepared(recordings, len(files), form, options, known_structure)
    train, validation = datasets[: len(files)], datasets[-1] if validate else None
    generator = np.random.default_rng(options.seed)
    result = fit(train, mechanism, options.method, options.settings, generator, progress, options.physical)
    relative = rig.torque.gain_source == "assumed" and not holds_torque(recordings[0])
    kept = effect_terms(mechanism.structure, mechanism.x) if isinstance(mechanism, LinearizedModel) else ()
    trust, knowledge = None, (ParameterUncertainty(),) * len(mechanism.parameters)
    if form is None:
        moved = _moved(train, mechanism, options)
        trust, knowledge = assess(train, result, mechanism, options.method, moved, relative, options.intervals)
    model = Model(
        mechanism=rig.mechanism,
        form=form,
        effects=tuple(term.name for term in kept),
        terms=kept,
        joints=rig.joint_names,
        effort_units=rig.effort_units,
        geometry=rig.geometry if rig.mechanism == "delta" else None,
        torque=rig.torque,
        relative=relative,
        parameters=_parameters(mechanism, result, knowledge),
        method=FitMethod(
            name=options.method,
            settings=asdict(options.settings),
            seed=options.seed,
            objective=result.estimate.objective,
            rows=result.rows,
            certified=_certified(result),
            diagnostics=dict(result.estimate.diagnostics),
        ),
        preprocessing=Preprocessing(
            name=options.preprocessing,
            bandwidth=train[0].bandwidth,
            rate=train[0].rate,
            cutoff=train[0].cutoff.sentence() if train[0].cutoff else None,
            delays=_delays(train, result) if form is None else None,
        ),
        train=_agreement(train, result),
        validate=_agreement([validation], result) if validation else None,
        trust=trust,
    )
    return Identification(model, mechanism, result, train, validation)


def _prepared(
    recordings: Sequence[Recording],
    fitted: int,
    form: str | None,
    choices: FitOptions,
    settled: tuple[ModelStructure, Floats] | None,
) -> tuple[Mechanism, tuple[Dataset, ...]]:
    """The model to fit, and the rows of all recordings; shapes of effects follow from the first `fitted` ones."""
    mechanism = mechanisms.create(recordings[0].rig, form)
    if not choices.effects and not settled:
        return mechanism, build_all(recordings, mechanism, choices.preprocessing, choices.cutoff)
    if form:
        raise BadInput(f"no --with expected beside a method that fits the form '{form}'; choose another method")
    chosen = None if choices.cutoff else _cutoff(recordings, mechanism, choices.preprocessing)
    cutoff = chosen.hz if chosen else choices.cutoff
    courses: Iterator[PreparedRecording] = (
        prepare(recording, choices.preprocessing, cutoff) for recording in recordings
    )
    if settled:
        frozen = LinearizedModel(*settled)
    else:
        seen = [next(courses) for _ in range(fitted)]
        frozen = fit_shape_parameters(
            seen, parse_terms(choices.effects, library(choices.effect_files), recordings[0])
        )
        courses = chain(seen, courses)
    datasets = (frozen.dataset(course) for course in courses)
    return frozen, tuple(replace(one, cutoff=chosen) if chosen else one for one in datasets)


def _cutoff(recordings: Sequence[Recording], mechanism: Mechanism, preprocessing: str) -> Cutoff | None:
    """The low-pass that all recordings bear; None where the preprocessing has no choice."""
    return build_all(recordings, mechanism, preprocessing, None)[0].cutoff


def _moved(train: Sequence[Dataset], mechanism: Mechanism, choices: FitOptions) -> Sensitivity:
    if isinstance(mechanism, LinearizedModel):  # their shapes would have to be searched for anew each time
        return Sensitivity(None, ())
    recordings = [dataset.recording for dataset in train]
    cutoff = train[0].cutoff.hz if train[0].cutoff else None
    return sensitivity(recordings, mechanisms.create, choices.preprocessing, cutoff)


def _parameters(mechanism: Mechanism, result: Fit, knowledge: Sequence[ParameterUncertainty]) -> tuple[FittedParameter, ...]:
    return tuple(
        FittedParameter(
            name=parameter.name,
            value=float(value),
            unit=parameter.unit,
            lower=float(lower),
            upper=float(upper),
            at_bound=at_bound,
            paper_value=float(parameter.paper_sign * value),
            **known.model_dump(),
        )
        for parameter, value, (lower, upper), at_bound, known in zip(
            mechanism.parameters, result.parameters, result.bounds, result.at_bound, knowledge, strict=True
        )
    )


def _delays(train: Sequence[Dataset], result: Fit) -> tuple[JointDelay, ...] | None:
    found = delays(train, result.parameters)
    if found is None:
        return None
    return tuple(JointDelay(seconds=one.seconds, half_width=one.half_width) for one in found)


def _certified(result: Fit) -> CertifiedMinimum | None:
    estimate = result.estimate
    if estimate.certificate is None:
        return None
    proof = estimate.certificate
    return CertifiedMinimum(minimum=proof.objective, lower_bound=proof.lower_bound, excess=proof.excess(estimate.objective))


def _agreement(datasets: Sequence[Dataset], result: Fit) -> Agreement:
    measured = np.concatenate([dataset.torque for dataset in datasets])
    computed = np.concatenate([result.torque(dataset) for dataset in datasets])
    nominal = [dataset.nominal for dataset in datasets if dataset.nominal is not None]
    return Agreement(
        recordings=tuple(recording_source(dataset.recording) for dataset in datasets),
        fitted=JointGoodnessOfFit.of(goodness_of_fit(measured, computed)),
        nominal=JointGoodnessOfFit.of(goodness_of_fit(measured, np.concatenate(nominal))) if nominal else None,
    )

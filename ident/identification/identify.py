"""Identify a model from recordings: read, preprocess, fit, and assess on training and validation data."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
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
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library as load_library
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.structure import ModelStructure
from ident.estimation import estimators
from ident.estimation.linear_fit import Fit, fit
from ident.estimation.linearized_model import LinearizedModel, fit_shape_parameters, parse_terms
from ident.estimation.problem import Progress
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.identification.model_file import (
    Agreement,
    CertifiedMinimum,
    FitMethod,
    FittedParameter,
    JointDelay,
    JointGoodnessOfFit,
    ModelFile,
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
    """The user's options."""

    method: str
    """Estimator."""
    settings: Any
    """Settings of the estimator."""
    seed: int
    preprocessing: str
    cutoff: float | None
    """[Hz]; None: chosen by the preprocessing."""
    effects: tuple[str, ...] = ()
    """Effects added to the mechanism: NAME, or NAME:1,3 for some joints."""
    library: Mapping[str, Effect] = field(default_factory=load_library)
    """Effects by name, in which `effects` are looked up."""
    physical: bool = False
    """Constrain friction to oppose motion."""
    intervals: IntervalMethod = "stationary"
    """Method of the confidence intervals, see `ident.uncertainty.covariance`."""


@dataclass(frozen=True, eq=False)
class Identification:
    """A fitted model with its data."""

    model: ModelFile
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
    """Fit the mechanism of the rig to the recordings `files` together, and assess it on them and on `validate`.

    known_structure: model structure with known shape and signal parameters, and all its parameters (K,); replaces the
    effects of `options`.

    Raises:
        BadInput: a recording cannot be used, recordings overlap, or they are not of the same rig.
    """
    recordings = [read(path) for path in (*files, *([validate] if validate else []))]
    rig = recordings[0].rig
    check_same_rig(recordings)
    check_no_overlap(recordings)
    form = estimators.form(options.method)
    mechanism, datasets = _mechanism_and_datasets(recordings, len(files), form, options, known_structure)
    train, validation = datasets[: len(files)], datasets[-1] if validate else None
    generator = np.random.default_rng(options.seed)
    result = fit(train, mechanism, options.method, options.settings, generator, progress, options.physical)
    relative = rig.torque.gain_source == "assumed" and not holds_torque(recordings[0])
    effects = effect_terms(mechanism.structure, mechanism.x) if isinstance(mechanism, LinearizedModel) else ()
    assessment, uncertainties = None, (ParameterUncertainty(),) * len(mechanism.parameters)
    if form is None:
        parameter_changes = _parameter_changes(train, mechanism, options)
        assessment, uncertainties = assess(
            train, result, mechanism, options.method, parameter_changes, relative, options.intervals
        )
    model = ModelFile(
        mechanism=rig.mechanism,
        form=form,
        effects=tuple(term.name for term in effects),
        terms=effects,
        joints=rig.joint_names,
        effort_units=rig.effort_units,
        geometry=rig.geometry if rig.mechanism == "delta" else None,
        torque=rig.torque,
        relative=relative,
        parameters=_parameters(mechanism, result, uncertainties),
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
        trust=assessment,
    )
    return Identification(model, mechanism, result, train, validation)


def _mechanism_and_datasets(
    recordings: Sequence[Recording],
    fitted: int,
    form: str | None,
    options: FitOptions,
    known_structure: tuple[ModelStructure, Floats] | None,
) -> tuple[Mechanism, tuple[Dataset, ...]]:
    """Return the model to fit and the data of all recordings.

    Shape parameters of effects are fitted to the first `fitted` recordings.
    """
    mechanism = mechanisms.create(recordings[0].rig, form)
    if not options.effects and not known_structure:
        return mechanism, build_all(recordings, mechanism, options.preprocessing, options.cutoff)
    if form:
        raise BadInput(f"--with cannot be combined with a method that fits the form '{form}'; choose another method")
    common_cutoff = None if options.cutoff else _cutoff(recordings, mechanism, options.preprocessing)
    cutoff = common_cutoff.hz if common_cutoff else options.cutoff
    prepared: Iterator[PreparedRecording] = (
        prepare(recording, options.preprocessing, cutoff) for recording in recordings
    )
    if known_structure:
        linearized = LinearizedModel(*known_structure)
    else:
        training = [next(prepared) for _ in range(fitted)]
        linearized = fit_shape_parameters(training, parse_terms(options.effects, options.library, recordings[0]))
        prepared = chain(training, prepared)
    datasets = (linearized.dataset(recording) for recording in prepared)
    return linearized, tuple(
        replace(dataset, cutoff=common_cutoff) if common_cutoff else dataset for dataset in datasets
    )


def _cutoff(recordings: Sequence[Recording], mechanism: Mechanism, preprocessing: str) -> Cutoff | None:
    """Common cut-off of all recordings; None if the preprocessing has a fixed one."""
    return build_all(recordings, mechanism, preprocessing, None)[0].cutoff


def _parameter_changes(train: Sequence[Dataset], mechanism: Mechanism, options: FitOptions) -> Sensitivity:
    if isinstance(mechanism, LinearizedModel):  # shape parameters would have to be fitted again for each change
        return Sensitivity(None, ())
    recordings = [dataset.recording for dataset in train]
    cutoff = train[0].cutoff.hz if train[0].cutoff else None
    return sensitivity(recordings, mechanisms.create, options.preprocessing, cutoff)


def _parameters(
    mechanism: Mechanism, result: Fit, uncertainties: Sequence[ParameterUncertainty]
) -> tuple[FittedParameter, ...]:
    return tuple(
        FittedParameter(
            name=parameter.name,
            value=float(value),
            unit=parameter.unit,
            lower=float(lower),
            upper=float(upper),
            at_bound=at_bound,
            paper_value=float(parameter.paper_sign * value),
            **uncertainty.model_dump(),
        )
        for parameter, value, (lower, upper), at_bound, uncertainty in zip(
            mechanism.parameters, result.parameters, result.bounds, result.at_bound, uncertainties, strict=True
        )
    )


def _delays(train: Sequence[Dataset], result: Fit) -> tuple[JointDelay, ...] | None:
    estimates = delays(train, result.parameters)
    if estimates is None:
        return None
    return tuple(JointDelay(seconds=delay.seconds, half_width=delay.half_width) for delay in estimates)


def _certified(result: Fit) -> CertifiedMinimum | None:
    estimate = result.estimate
    if estimate.certificate is None:
        return None
    certificate = estimate.certificate
    return CertifiedMinimum(
        minimum=certificate.objective,
        lower_bound=certificate.lower_bound,
        excess=certificate.excess(estimate.objective),
    )


def _agreement(datasets: Sequence[Dataset], result: Fit) -> Agreement:
    measured = np.concatenate([dataset.torque for dataset in datasets])
    computed = np.concatenate([result.torque(dataset) for dataset in datasets])
    nominal = [dataset.nominal for dataset in datasets if dataset.nominal is not None]
    return Agreement(
        recordings=tuple(recording_source(dataset.recording) for dataset in datasets),
        fitted=JointGoodnessOfFit.of(goodness_of_fit(measured, computed)),
        nominal=JointGoodnessOfFit.of(goodness_of_fit(measured, np.concatenate(nominal))) if nominal else None,
    )

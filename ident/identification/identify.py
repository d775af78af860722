"""Identify a model from recordings: read, preprocess, fit, and assess on training and validation data."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from numbers import Integral, Real
from typing import Any, get_args

import numpy as np

from ident.data.compatibility import check_no_overlap, check_same_rig
from ident.data.prepared_recording import PreparedRecording, prepare_all
from ident.data.samples import holds_torque
from ident.data_problems import examined, listed
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library as load_library
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation import estimators, nonlinear_swarm
from ident.estimation.linear_fit import Fit, fit
from ident.estimation.nonlinear_swarm import SwarmSearch
from ident.estimation.problem import Progress
from ident.estimation.regression import Regression, linearize
from ident.estimation.shape_parameters import fit_shape_parameters
from ident.identification.chosen_effects import check_effect_name, mandatory_terms, parse_terms
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.identification.model_file import (
    Agreement,
    CertifiedMinimum,
    FitMethod,
    FittedParameter,
    ModelFile,
    Preprocessing,
    recording_source,
)
from ident.identification.prediction import Prediction, effect_terms, searched_parameters
from ident.uncertainty.assessment import Assessment, ParameterUncertainty, assess
from ident.uncertainty.covariance import IntervalMethod
from ident.uncertainty.sensitivity import Sensitivity, sensitivity
from ident.uncertainty.time_delay import delays
from recordings.errors import BadInput, expect
from recordings.reader import Source, opened
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
    base_effects: bool = False
    """Whether the base model includes what every real machine of this kind has, the mandatory effects."""
    without: tuple[str, ...] = ()
    """Mandatory effects that are left out nevertheless."""
    physical: bool = False
    """Constrain friction to oppose motion."""
    intervals: IntervalMethod = "stationary"
    """Method of the confidence intervals, see `ident.uncertainty.covariance`."""
    accept: tuple[str, ...] = ()
    """Kinds of data problems in spite of which the recordings are used."""

    def __post_init__(self) -> None:
        expect(Integral, "a whole number", seed=self.seed)
        expect(Real | None, "a number", cutoff=self.cutoff)
        expect(str, "a name", preprocessing=self.preprocessing)
        expect(bool, "True or False", physical=self.physical)
        for name in self.effects:
            check_effect_name(name.partition(":")[0], self.library)
        if self.intervals not in get_args(IntervalMethod):
            methods = ", ".join(get_args(IntervalMethod))
            raise BadInput(f"intervals: one of {methods} expected, {self.intervals!r} found")
        if self.seed < 0:
            raise BadInput(f"a seed of 0 or more expected, {self.seed} found")


@dataclass(frozen=True, eq=False)
class Identification:
    """A fitted model with its data."""

    model: ModelFile
    structure: ModelStructure
    x: Floats
    """(K,) parameters at which the model was linearized; the linear ones were then fitted again."""
    fit: Fit
    train: tuple[Regression, ...]
    validation: Regression | None

    @property
    def parameters(self) -> Floats:
        """(K,) all fitted parameters."""
        return _with_linear(self.structure, self.x, self.fit)

    @property
    def predictions(self) -> tuple[Prediction, ...]:
        """The training recordings, and then the validation recording if there is one."""
        regressions = [*self.train, *([self.validation] if self.validation else [])]
        return tuple(Prediction(each.prepared, each.predicted_torque(self.fit.parameters)) for each in regressions)


def identify(
    files: Sequence[Source],
    validate: Source | None,
    options: FitOptions,
    progress: Progress,
    known_structure: tuple[ModelStructure, Floats] | None = None,
) -> Identification:
    """Fit the mechanism of the rig to the recordings `files` together, and assess it on them and on `validate`.

    known_structure: model structure with known shape and signal parameters, and all its parameters (K,); replaces the
    effects of `options`.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, recordings overlap, or they are not of the same rig.
    """
    recordings = [opened(source) for source in (*files, *([validate] if validate else []))]
    check_same_rig(recordings)
    check_no_overlap(recordings)
    form = estimators.form(options.method)
    if form and options.effects:
        raise BadInput(f"--with cannot be combined with a method that fits the form '{form}'; choose another method")

    def prepare(recordings: Sequence[Recording]) -> list[list[PreparedRecording]]:
        return [[each] for each in prepare_all(recordings, options.preprocessing, options.cutoff, form)]

    usable = examined(recordings, prepare, options.accept)
    prepared = [excerpt for each in usable for excerpt in each.excerpts]
    train = prepared[: len(files)]
    searched = _search(train, options, progress) if estimators.declares(options.method, "NONLINEAR") else None
    structure, x = (searched.structure, searched.x) if searched else known_structure or _structure(train, options)
    regressions = tuple(linearize(each, structure, x) for each in prepared)
    train_rows, validation = regressions[: len(files)], regressions[-1] if validate else None
    generator = np.random.default_rng(options.seed)
    result = fit(
        train_rows,
        structure.linear_parameters,
        options.method,
        options.settings,
        generator,
        progress,
        options.physical,
    )
    if searched:
        result = _with_search(result, searched)
    agreements = _agreement(train_rows, result), _agreement([validation], result) if validation else None
    method, assessed = _fit_method(options, result), _assessed(options, train_rows, structure, x, result)
    model = model_of(train_rows, structure, x, result, method, options.preprocessing, assessed, agreements)
    problems = listed(recordings, [each.problems for each in usable])
    model = model.model_copy(update={"form": form, "data_problems": problems})
    return Identification(model, structure, x, result, train_rows, validation)


def _fit_method(options: FitOptions, result: Fit) -> FitMethod:
    return FitMethod(
        name=options.method,
        settings=asdict(options.settings),
        seed=options.seed,
        objective=result.estimate.objective,
        rows=result.rows,
        certified=_certified(result),
        diagnostics=dict(result.estimate.diagnostics),
    )


def _assessed(
    options: FitOptions, train: Sequence[Regression], structure: ModelStructure, x: Floats, result: Fit
) -> tuple[Assessment | None, Sequence[ParameterUncertainty]]:
    """Assessment of the model and of each linear parameter; none of another form than the mechanism's own."""
    if estimators.form(options.method):
        return None, (ParameterUncertainty(),) * len(structure.linear_parameters)
    changes = _parameter_changes(train, structure, options.preprocessing)
    relative, fitted = is_relative(train[0].prepared.recording), _with_linear(structure, x, result)
    return assess(train, result, structure, options.method, changes, relative, options.intervals, fitted)


def _with_linear(structure: ModelStructure, x: Floats, result: Fit) -> Floats:
    """(K,) `x` with the linear parameters of the `result`."""
    fitted = x.copy()
    fitted[structure.linear] = result.parameters
    return fitted


def is_relative(recording: Recording) -> bool:
    """Return whether parameters fitted to `recording` are known only up to one common factor."""
    return recording.rig.torque.gain_source == "assumed" and not holds_torque(recording)


def model_of(
    train: Sequence[Regression],
    structure: ModelStructure,
    x: Floats,
    result: Fit,
    method: FitMethod,
    preprocessing: str,
    assessed: tuple[Assessment | None, Sequence[ParameterUncertainty]],
    agreements: tuple[Agreement, Agreement | None],
) -> ModelFile:
    """Describe a fitted model as a file.

    assessed: of the whole and of each linear parameter. agreements: with training and validation data.
    """
    rig, prepared = train[0].prepared.recording.rig, train[0].prepared
    effects, cutoff = effect_terms(structure, x), prepared.cutoff
    return ModelFile(
        mechanism=rig.mechanism,
        effects=tuple(term.name for term in effects),
        terms=effects,
        joints=rig.joint_names,
        effort_units=rig.effort_units,
        geometry=rig.geometry if rig.mechanism == "delta" else None,
        robot=rig.chain if rig.mechanism == "urdf" else None,
        torque=rig.torque,
        relative=is_relative(prepared.recording),
        parameters=_parameters(structure, result, assessed[1]),
        searched=searched_parameters(structure, x, np.full((len(x), 2), np.nan)),
        method=method,
        preprocessing=Preprocessing(
            name=preprocessing,
            bandwidth=prepared.bandwidth,
            rate=prepared.rate,
            cutoff=cutoff.sentence() if cutoff else None,
            delays=delays(train, result.parameters) if assessed[0] else None,
        ),
        train=agreements[0],
        validate=agreements[1],
        assessment=assessed[0],
    )


def _structure(train: Sequence[PreparedRecording], options: FitOptions) -> tuple[ModelStructure, Floats]:
    """The mechanism with the chosen effects, whose shapes are fitted to `train`, and all parameters (K,)."""
    terms = _terms(train, options)
    if options.effects:
        return fit_shape_parameters(train, terms)
    structure = replace(train[0].base_structure, terms=terms)
    return structure, np.zeros(len(structure.parameters))


def _search(train: Sequence[PreparedRecording], options: FitOptions, progress: Progress) -> SwarmSearch:
    """The mechanism with the chosen effects, whose shapes a swarm searches."""
    generator = np.random.default_rng(options.seed)
    return nonlinear_swarm.search(
        train, _terms(train, options), options.settings, generator, progress, options.physical
    )


def _with_search(result: Fit, searched: SwarmSearch) -> Fit:
    """Add the convergence of the search to the `result` of the linear fit."""
    steps = {"iterations": len(searched.history) - 1, "evaluations": searched.evaluations}
    estimate = replace(result.estimate, history=searched.history, diagnostics=steps)
    return replace(result, estimate=estimate)


def _terms(train: Sequence[PreparedRecording], options: FitOptions) -> tuple[Term, ...]:
    """Effects of the base model, and the chosen ones."""
    recording = train[0].recording
    chosen = parse_terms(options.effects, options.library, recording)
    base: tuple[Term, ...] = ()
    if options.base_effects and estimators.form(options.method) is None:
        base = mandatory_terms(options.library, recording, options.without)
    return (*(term for term in base if term.name not in {other.name for other in chosen}), *chosen)


def _parameter_changes(train: Sequence[Regression], structure: ModelStructure, preprocessing: str) -> Sensitivity:
    """Changes of the parameters; none for effects whose shapes would have to be fitted again for each change."""
    if not all(term.effect.mandatory for term in structure.terms):
        return Sensitivity(None, ())
    cutoff = train[0].prepared.cutoff
    recordings = [regression.prepared.recording for regression in train]
    return sensitivity(recordings, preprocessing, cutoff.hz if cutoff else None, structure.terms)


def _parameters(
    structure: ModelStructure, result: Fit, uncertainties: Sequence[ParameterUncertainty]
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
            meaning=parameter.meaning,
            **uncertainty.model_dump(),
        )
        for parameter, value, (lower, upper), at_bound, uncertainty in zip(
            structure.linear_parameters, result.parameters, result.bounds, result.at_bound, uncertainties, strict=True
        )
    )


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


def _agreement(regressions: Sequence[Regression], result: Fit) -> Agreement:
    return agreement(
        [regression.prepared for regression in regressions],
        [regression.torque for regression in regressions],
        [regression.predicted_torque(result.parameters) for regression in regressions],
    )


def agreement(
    recordings: Sequence[PreparedRecording], measured: Sequence[Floats], computed: Sequence[Floats]
) -> Agreement:
    """Agreement of the torques `measured` and `computed` (m, dof) of all `recordings`; NaN is skipped."""
    torque = np.concatenate(measured)
    nominal = [each.nominal for each in recordings if each.nominal is not None]
    paths = {each.recording.path: each.recording for each in recordings}
    return Agreement(
        recordings=tuple(map(recording_source, paths.values())),
        fitted=goodness_of_fit(torque, np.concatenate(computed)),
        nominal=goodness_of_fit(torque, np.concatenate(nominal)) if nominal else None,
    )

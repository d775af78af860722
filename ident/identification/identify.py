"""Identify a model from recordings: read, preprocess, fit, and assess on training and validation data."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from numbers import Integral, Real
from typing import Any, get_args

import numpy as np

from ident.data.compatibility import check_no_overlap, check_same_rig, of_one_set_up, reference_payload
from ident.data.prepared_recording import PreparedRecording, prepare_all
from ident.data.row_weights import FittedRows, fitted_rows
from ident.data.samples import is_relative
from ident.data_problems import examined, listed
from ident.dynamics.effects import unknown_payload
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library as load_library
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation import estimators, nonlinear_swarm
from ident.estimation.linear_fit import Fit, fit
from ident.estimation.nonlinear_swarm import SwarmSearch
from ident.estimation.possible_links import bound_to_bodies
from ident.estimation.problem import Progress
from ident.estimation.regression import Regression, linearize
from ident.estimation.shape_parameters import fit_shape_parameters
from ident.identification.chosen_effects import check_effect_name, mandatory_terms, parse_terms
from ident.identification.model_description import agreement, model_of
from ident.identification.model_file import (
    Agreement,
    CertifiedMinimum,
    FitMethod,
    ModelFile,
)
from ident.identification.prediction import Prediction
from ident.uncertainty.assessment import Assessment, ParameterUncertainty, assess
from ident.uncertainty.covariance import IntervalMethod
from ident.uncertainty.sensitivity import Sensitivity, sensitivity
from recordings.errors import BadInput, expect, told
from recordings.reader import Source, opened
from recordings.recording import Floats, Recording
from recordings.rig import Rig


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
    by_default: bool = False
    """Whether nobody chose the method."""

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
    validation: tuple[Regression, ...]

    @property
    def parameters(self) -> Floats:
        """(K,) all fitted parameters."""
        return _with_linear(self.structure, self.x, self.fit)

    @property
    def predictions(self) -> tuple[Prediction, ...]:
        """The training recordings, and then those for validation."""
        return tuple(
            Prediction(each.prepared, each.predicted_torque(self.fit.parameters))
            for each in (*self.train, *self.validation)
        )


def _for_rig(options: FitOptions, rig: Rig) -> FitOptions:
    """The `options`; where nobody chose the method, a URDF has one that finds its tens of parameters."""
    if not options.by_default or rig.mechanism != "urdf":
        return options
    return replace(options, method="wls", settings=estimators.settings("wls", {}))


def identify(
    files: Sequence[Source],
    validate: Sequence[Source],
    options: FitOptions,
    progress: Progress,
) -> Identification:
    """Fit the mechanism of the rig to the recordings `files` together, and assess it on them and on `validate`.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, recordings overlap, or they are not of the same rig.
    """
    recordings = [opened(source) for source in (*files, *validate)]
    payload = reference_payload(recordings)
    recordings = [of_one_set_up(each, payload) for each in recordings]
    check_same_rig(recordings)
    check_no_overlap(recordings)
    options = _for_rig(options, recordings[0].rig)
    form = estimators.form(options.method)
    if form and options.effects:
        raise BadInput(
            f"{told('--with', 'effects')} cannot be combined with a method that fits the form '{form}'; choose "
            "another method"
        )

    def prepare(recordings: Sequence[Recording]) -> list[list[PreparedRecording]]:
        return [[each] for each in prepare_all(recordings, options.preprocessing, options.cutoff, form)]

    usable = examined(recordings, prepare, options.accept)
    prepared = [excerpt for each in usable for excerpt in each.excerpts]
    train: Sequence[PreparedRecording] = prepared[: len(files)]
    weighted, of_links = estimators.declares(options.method, "WEIGHTED"), isinstance(train[0].mechanism, Urdf)
    rows = fitted_rows(train) if weighted or of_links else None
    train = bound_to_bodies(train, rows.rows, rows.weights) if rows and of_links else train
    searched = None
    if estimators.declares(options.method, "NONLINEAR"):
        generator = np.random.default_rng(options.seed)
        searched = nonlinear_swarm.search(
            train, _terms(train, options), options.settings, generator, progress, options.physical
        )
    if searched:
        structure, x = searched.structure, searched.x
    else:
        structure, x, rows = _structure(train, options, rows if weighted else None)
    regressions = tuple(linearize(each, structure, x) for each in prepared)
    train_rows, validation = regressions[: len(files)], regressions[len(files) :]
    generator = np.random.default_rng(options.seed)
    result = fit(
        train_rows,
        structure.linear_parameters,
        options.method,
        options.settings,
        generator,
        progress,
        options.physical,
        structure.bodies,
        rows,
    )
    if searched:
        result = _with_search(result, searched)
    agreements = _agreement(train_rows, result), _agreement(validation, result) if validation else None
    method, assessed = _fit_method(options, result), _assessed(options, train_rows, structure, x, result)
    model = model_of(train_rows, structure, x, result, method, options.preprocessing, assessed, agreements)
    problems = listed(recordings, [each.problems for each in usable])
    model = model.model_copy(update={"form": form, "data_problems": problems})
    return Identification(model, structure, x, result, train_rows, validation)


def _fit_method(options: FitOptions, result: Fit) -> FitMethod:
    estimate, certificate = result.estimate, result.estimate.certificate
    certified = (
        None
        if certificate is None
        else CertifiedMinimum(
            minimum=certificate.objective,
            lower_bound=certificate.lower_bound,
            excess=certificate.excess(estimate.objective),
        )
    )
    return FitMethod(
        name=options.method,
        settings=asdict(options.settings),
        seed=options.seed,
        objective=estimate.objective,
        rows=result.rows,
        certified=certified,
        diagnostics=dict(estimate.diagnostics),
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


def _structure(
    train: Sequence[PreparedRecording], options: FitOptions, rows: FittedRows | None
) -> tuple[ModelStructure, Floats, FittedRows | None]:
    """The mechanism with the chosen effects, whose shapes are fitted to `train`, and all parameters (K,).

    rows: those of a weighted fit, which are returned with weights of this model.
    """
    terms = _terms(train, options)
    if options.effects or any(term.shapes for term in terms):
        return fit_shape_parameters(train, terms, rows)
    structure = replace(train[0].base_structure, terms=terms)
    return structure, np.zeros(len(structure.parameters)), rows


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
    if payload := unknown_payload.needed_by([each.recording for each in train]):
        base = (*base, Term.on_all_joints(unknown_payload.NAME, payload, recording.rig))
    return (*(term for term in base if term.name not in {other.name for other in chosen}), *chosen)


def _parameter_changes(train: Sequence[Regression], structure: ModelStructure, preprocessing: str) -> Sensitivity:
    """Changes of the parameters; none for effects whose shapes would have to be fitted again for each change."""
    if not all(term.effect.mandatory for term in structure.terms):
        return Sensitivity(None, ())
    cutoff = train[0].prepared.cutoff
    recordings = [regression.prepared.recording for regression in train]
    return sensitivity(recordings, preprocessing, cutoff.hz if cutoff else None, structure.terms)


def _agreement(regressions: Sequence[Regression], result: Fit) -> Agreement:
    return agreement(
        [regression.prepared for regression in regressions],
        [regression.torque for regression in regressions],
        [regression.predicted_torque(result.parameters) for regression in regressions],
    )

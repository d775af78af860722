"""Diagnose recordings: missing effects, their alternatives, and the residual that remains unexplained."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, islice
from numbers import Real

import numpy as np

from ident.basics.threads import in_threads
from ident.data.compatibility import check_no_overlap, check_same_rig, of_one_set_up, refuse_unknown_payload
from ident.data.excerpts import excerpts
from ident.data.prepared_recording import PreparedRecording, common_cutoff, prepare
from ident.data_problems import examined, listed
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.ripple.ripple import Ripple, below_low_pass, find_ripple
from ident.diagnosis.ripple.vibration_alternative import with_vibration_alternatives
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.split.observability import Observability, observability
from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.split.train_test_split import split_recordings
from ident.diagnosis.unknown.imitation import analyse_unexplained
from ident.diagnosis.unknown.residual_dependence import NonparametricFit
from ident.diagnosis.unknown.residual_test import UnexplainedResidual, estimate_unexplained, with_vibrations
from ident.diagnosis.unknown.weightless import compare_without_weight
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure
from ident.identification.chosen_effects import check_effect_name
from ident.identification.model_file import ModelFile
from ident.identification.prediction import check_model_rig, structure_of
from recordings.data_problems import DataProblem
from recordings.errors import BadInput, expect
from recordings.reader import Source, opened
from recordings.recording import Floats, Recording

StatusCallback = Callable[[str], None]


@dataclass(frozen=True)
class DiagnosisOptions:
    """Options of the user."""

    preprocessing: str = "parallel"
    cutoff: float | None = None
    """[Hz]; None: chosen from the spectra."""
    only: tuple[str, ...] = ()
    """Effects to add in this order, without any others; empty: stepwise selection."""
    without: tuple[str, ...] = ()
    """Effects of the library that are left out."""
    accept: tuple[str, ...] = ()
    """Kinds of data problems in spite of which the recordings are used."""

    def __post_init__(self) -> None:
        expect(Real | None, "a number", cutoff=self.cutoff)
        expect(str, "a name", preprocessing=self.preprocessing)


@dataclass(frozen=True, eq=False)
class DiagnosisInputs:
    """Data, effects and initial model of a diagnosis."""

    split: SplitData
    effects: Observability
    excerpt_share: float | None
    """Share of the rows that is analysed, if the recordings are too long to analyse them completely."""
    problems: tuple[DataProblem, ...] = ()
    """What cannot be right about the recordings, but does not keep from using them."""

    def initial_model(
        self, library: Mapping[str, Effect], model: ModelFile | None = None
    ) -> tuple[ModelStructure, Floats]:
        """The structure and initial parameters (K,) of `model`, or of the mechanism without effects.

        Raises:
            BadInput: the model is of another rig.
        """
        prepared = self.split.recordings[0]
        if model is None:
            return prepared.base_structure, np.zeros(len(prepared.base_structure.parameters))
        check_model_rig(model, prepared.recording)
        if model.form:
            raise BadInput(
                f"a model of the mechanism itself expected, found one of the form '{model.form}', which the method "
                f"{model.method.name} fits; choose another method"
            )
        structure, x = structure_of(model, prepared.recording.rig, library)
        return below_low_pass(replace(structure, mechanism=prepared.mechanism), x, self.split.recordings)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The result of a diagnosis, with the data behind it."""

    split: SplitData
    library: Mapping[str, Effect]
    effects: Observability
    selection: Selection
    unexplained: UnexplainedResidual
    learned: NonparametricFit | None
    """Learned curves for the unexplained residual, if it depends on any variable."""
    ripple: Ripple
    """What lies above the low-pass."""
    excerpt_share: float | None
    """Share of the rows that was analysed, if the recordings were too long to analyse them completely."""
    data_problems: tuple[DataProblem, ...] = ()
    forced: bool = False
    """Whether the user chose the effects and no others were tried."""
    without_weight: bool = False
    """Whether the final model is much better without weight, where no mass is known."""

    @property
    def model(self) -> FittedModel:
        """The final model."""
        return self.selection.model


def diagnose(
    files: Sequence[Source],
    validate: Sequence[Source],
    library: Mapping[str, Effect],
    options: DiagnosisOptions,
    progress: StatusCallback = lambda text: None,
    initial_model: ModelFile | None = None,
) -> Diagnosis:
    """Find the effects of the `library` that the base model lacks in the recordings `files`.

    validate: recordings of other motions, used only for validation; without any, phase segments are held out.
    initial_model: the model whose effects are the starting point; None: the mechanism without effects.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, the recordings or the model are not of the same rig, or a requested
            effect does not exist or cannot be observed.
    """
    _check_effects((*options.only, *options.without), library, {})
    inputs = prepare_inputs(files, validate, library, options)
    effects = inputs.effects
    _check_effects(options.only, library, {**effects.unobservable, **effects.untested})
    search = Search(inputs.split, effects.observable, progress)
    start = inputs.initial_model(library, initial_model)
    selection = search.select_forced(*start, options.only) if options.only else search.select(*start)
    progress("analysing the unexplained residual")
    selection, unexplained, learned = analyse_unexplained(search, selection, bool(options.only))
    # All steps are scored on the rows that the last model can judge, so that their errors can be compared.
    selection = selection.on(selection.model.on_judged_rows.split)
    progress("searching ripple above the low-pass")
    wanted = {name: effect for name, effect in effects.observable.items() if not options.only or name in options.only}
    ripple = find_ripple(selection.model, wanted)
    if ripple.lines and not (with_ripple := estimate_unexplained(ripple.whole, ())).significant:
        unexplained, learned = with_ripple, None
    split = selection.model.split
    selection, without_weight = compare_without_weight(with_vibration_alternatives(selection))
    return Diagnosis(
        split,
        library,
        effects,
        selection,
        with_vibrations(unexplained, ripple.vibrations, split.torque_rms),
        learned,
        ripple,
        inputs.excerpt_share,
        inputs.problems,
        bool(options.only),
        without_weight,
    )


def _check_effects(names: Sequence[str], library: Mapping[str, Effect], not_shown: Mapping[str, str]) -> None:
    for name in names:
        check_effect_name(name, library)
        if name in not_shown:
            raise BadInput(f"effect: one that these recordings can show expected, '{name}' found: {not_shown[name]}")


def prepare_inputs(
    files: Sequence[Source], validate: Sequence[Source], library: Mapping[str, Effect], options: DiagnosisOptions
) -> DiagnosisInputs:
    """Read and prepare recordings as `diagnose` uses them.

    Raises:
        BadInput: a recording cannot be used, or the recordings are not of the same rig.
    """
    first, *others = in_threads(opened, (*files, *validate))
    refuse_unknown_payload([first, *others])
    recordings = (first, *(of_one_set_up(each, first.rig.payload) for each in others))
    check_same_rig(recordings)
    check_no_overlap(recordings)
    usable = examined(recordings, partial(_prepare_recordings, options), options.accept)
    prepared = [each.excerpts for each in usable]
    train, test = prepared[: len(files)], prepared[len(files) :]
    split = split_recordings(list(chain.from_iterable(train)), list(chain.from_iterable(test)))
    kept = sum(len(excerpt.recording.time) for excerpt in chain.from_iterable(prepared))
    whole = sum(len(recording.time) for recording in recordings)
    return DiagnosisInputs(
        split,
        observability(split, library, options.without),
        None if kept == whole else kept / whole,
        listed(recordings, [each.problems for each in usable]),
    )


def _prepare_recordings(options: DiagnosisOptions, recordings: Sequence[Recording]) -> list[list[PreparedRecording]]:
    """The prepared excerpts of each recording, all with the same cut-off."""
    excerpt_lists = [excerpts(recording) for recording in recordings]
    cutoff = common_cutoff(recordings, options.preprocessing) if options.cutoff is None else options.cutoff
    prepared = iter(
        in_threads(
            lambda excerpt: prepare(excerpt.recording, options.preprocessing, cutoff, excerpt.start, excerpt.end),
            chain.from_iterable(excerpt_lists),
        )
    )
    return [list(islice(prepared, len(excerpt_list))) for excerpt_list in excerpt_lists]

"""Diagnose recordings: missing effects, their alternatives, and the residual that remains unexplained."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np

from ident import filters
from ident.data import cutoff
from ident.data.excerpts import excerpts
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data.samples import holds_torque, sample
from ident.diagnosis.misspecification_check import remove_imitations
from ident.diagnosis.nonparametric_fit import NonparametricFit, fit_curves
from ident.diagnosis.split_data import SplitData, split_recordings
from ident.diagnosis.steps import Selection
from ident.diagnosis.stepwise_selection import Selector
from ident.diagnosis.unexplained_residual import UnexplainedResidual, estimate_unexplained
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition
from ident.identification.identify import refuse_different_rigs, refuse_overlap, refuse_the_same_twice
from ident.identification.model import Model
from ident.identification.prediction import composition_of, refuse_other_rig
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording

MAX_ENCODER_NOISE = 0.004
"""Largest ratio of encoder noise to torque: the smallest relevant effects are not much larger."""
MIN_BANDWIDTH = 10.0
"""The cut-off is not lowered below this for coarse encoders, because friction at reversals matters more [Hz]."""

_TINY = 1e-12
MAX_TORQUE_LOSS = 0.1
"""Largest share of the torque RMS that a lower cut-off may remove: otherwise ripple would be lost."""

StatusCallback = Callable[[str], None]


@dataclass(frozen=True)
class DiagnosisOptions:
    """Options of the user."""

    preprocessing: str = "parallel"
    cutoff: float | None = None
    """[Hz]; None: chosen from the spectra."""
    only: tuple[str, ...] = ()
    """Effects to add in this order, without any others; empty: stepwise selection."""


@dataclass(frozen=True, eq=False)
class DiagnosisInputs:
    """Data, effects and initial model of a diagnosis."""

    split: SplitData
    observable: Mapping[str, Effect]
    """Effects that such recordings can show."""
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, with the reason."""
    excerpt_share: float | None
    """Share of the rows that is analysed, if the recordings are too long to analyse them completely."""

    def initial_model(self, library: Mapping[str, Effect], model: Model | None = None) -> tuple[Composition, Floats]:
        """The structure and initial parameters (K,) of `model`, or of the mechanism without effects.

        Raises:
            BadInput: the model is of another rig.
        """as_recordedprepared
        path = self.split.predictors[0].course.path
        if model is None:
            bare = Composition(path.mechanism, path.rig)
            return bare, np.zeros(len(bare.named))
        refuse_other_rig(model, self.split.datasets[0].recording)
        return composition_of(model, path.rig, library)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The result of a diagnosis, with the data behind it."""

    split: SplitData
    library: Mapping[str, Effect]
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, with the reason."""
    selection: Selection
    unexplained: UnexplainedResidual
    learned: NonparametricFit | None
    """Learned curves for the unexplained residual, if it depends on any variable."""
    excerpt_share: float | None
    """Share of the rows that was analysed, if the recordings were too long to analyse them completely."""
    forced: bool = False
    """Whether the user chose the effects and no others were tried."""


def diagnose(
    files: Sequence[Path],
    validate: Sequence[Path],
    library: Mapping[str, Effect],
    options: DiagnosisOptions,
    progress: StatusCallback = lambda what: None,
    initial_model: Model | None = None,
) -> Diagnosis:
    """Find the effects of the `library` that the base model lacks in the recordings `files`.

    validate: recordings of other motions, used only for validation; without any, phase segments are held out.
    initial_model: the model whose effects are the starting point; None: the mechanism without effects.

    Raises:
        BadInput: a recording cannot be used, the recordings are not of the same rig, or a requested effect does not
            exist or cannot be observed.
    """
    _check_effects(options.only, library, {})
    asked = prepare_inputs(files, validate, library, options)
    _check_effects(options.only, library, asked.unobservable)
    material, climber = asked.split, Selector(asked.split, asked.observable, progress)
    beginning = asked.initial_model(library, initial_model)
    ladder = _select(climber, beginning, options)
    told = material.without_saturated_rows(ladder.steps[-1].model.solution, ladder.noise_floor.rms)
    if told is not material:
        material, climber = told, Selector(told, asked.observable, progress)
        ladder = _select(climber, beginning, options)
    progress("what remains")
    left = estimate_unexplained(material, ladder.steps[-1].model, ladder.noise_floor)
    stand_in = None
    if left.significant:
        ladder = ladder if options.only else remove_imitations(material, climber, ladder)
        stand_in = fit_curves(material, ladder.steps[-1].model)
        known = stand_in.dependences if stand_in and stand_in.supported else None
        left = estimate_unexplained(material, ladder.steps[-1].model, ladder.noise_floor, known)
    return Diagnosis(material, library, asked.unobservable, ladder, left, stand_in, asked.excerpt_share, bool(options.only))


def _check_effects(names: Sequence[str], library: Mapping[str, Effect], unobservable: Mapping[str, str]) -> None:
    for name in names:
        if name not in library:
            raise BadInput(f"effect: one of {', '.join(sorted(library))} expected, '{name}' found; correct it")
        if name in unobservable:
            raise BadInput(
                f"effect: one that these recordings can show expected, '{name}' found: {unobservable[name]}"
            )


def _select(climber: Selector, beginning: tuple[Composition, Floats], choices: DiagnosisOptions) -> Selection:
    return climber.select_forced(*beginning, choices.only) if choices.only else climber.select(*beginning)


def prepare_inputs(
    files: Sequence[Path], validate: Sequence[Path], library: Mapping[str, Effect], options: DiagnosisOptions
) -> DiagnosisInputs:
    """Read and prepare recordings as `diagnose` uses them.

    Raises:
        BadInput: a recording cannot be used, or the recordings are not of the same rig.
    """
    refuse_the_same_twice((*files, *validate))
    recordings = [read(path) for path in (*files, *validate)]
    refuse_different_rigs(recordings)
    refuse_overlap(recordings)
    courses, share = _prepare_recordings(recordings, options)
    train, held = courses[: len(files)], courses[len(files) :]
    material = split_recordings(list(chain.from_iterable(train)), list(chain.from_iterable(held)))
    return DiagnosisInputs(material, *_observable_effects(recordings[0], library), share)

PreparedRecording
def _prepare_recordings(recordings: Sequence[Recording], choices: DiagnosisOptions) -> tuple[list[list[Course]], float | None]:
    """The prepared excerpts of each recording, all at the lowest cut-off of any, and the share of rows in them."""
    cut = [excerpts(recording) for recording in recordings]
    choices = replace(choices, cutoff=choices.cutoff or _choose_cutoff(recordings))
    courses = [
        [prepare(part.recording, choices.preprocessing, choices.cutoff, part.start) for part in parts]
        for parts in cut
    ]preprocessed
    lowest = min(course.prepared.bandwidth for group in courses for course in group)
    same = [
        [
            coursepreprocessed
            if course.prepared.bandwidth == lowest
            else prepare(course.recording, choices.preprocessing, lowest, course.start)
            for course in group
        ]
        for group in courses
    ]
    kept = sum(len(part.recording.time) for parts in cut for part in parts)
    whole = sum(len(recording.time) for recording in recordings)
    return same, None if kept == whole else kept / whole


def _choose_cutoff(recordings: Sequence[Recording]) -> float:
    """A cut-off [Hz] that leaves less encoder noise than a fit would tolerate, because effects are small."""
    found = []
    for recording in recordings:
        samples = sample(excerpts(recording)[0].recording)
        position, torque = samples.position, samples.torque
        spectra = cutofchoose_from_spectratra(position, torque, samples.rate)
        usual = cutoff.decide(choose_from_spectraa, samples.rate).hz
        fine = min(max(cutoff.decide(spectra, samples.rate, MAX_ENCODER_NOISE).hz, MIN_BANDWIDTH), usual)
        found.append(usual if _band_share(torque, samples.rate, fine, usual) > MAX_TORQUE_LOSS else fine)
    return min(found)


def _band_share(torque: Floats, rate: float, low: float, high: float) -> float:
    """Share of the RMS of `torque` (n, dof) below `high` that lies above `low` [Hz], of the joint with most."""
    if low >= high:
        return 0.0
    more, less = (filters.convolve(torque, filters.low_pass(hz, rate)) for hz in (high, low))
    share: Floats = np.nanstd(more - less, axis=0) / np.maximum(np.nanstd(more, axis=0), _TINY)
    return float(np.nanmax(share))


def _observable_effects(recording: Recording, library: Mapping[str, Effect]) -> tuple[dict[str, Effect], dict[str, str]]:
    """The effects that such a recording can show, and the reasons why it cannot show the others of this mechanism."""
    rig, torque_measured = recording.rig, holds_torque(recording)
    offered, unobservable = {}, {}
    for name, effect in library.items():
        if rig.mechanism not in effect.mechanisms:
            continue
        why = effect.unobservable(rig, torque_measured)
        if why:
            unobservable[name] = why
        else:
            offered[name] = effect
    return offered, unobservable

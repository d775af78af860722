"""From recordings to the answer: is anything missing, what, what else could it be, and what remains."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np

from ident import filters
from ident.data import cutoff
from ident.data.excerpts import excerpts
from ident.data.prepared_recording import Course, prepare
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
"""Encoder noise in the torque, over the torque: the smallest effects that matter are not much larger."""
MIN_BANDWIDTH = 10.0
"""Where coarse encoders ask for less than this, friction at reversals counts for more [Hz]."""

_TINY = 1e-12
MAX_TORQUE_LOSS = 0.1
"""Share of the torque, in RMS, that a low-pass must not take away because of encoder noise: ripple would be gone."""

StatusCallback = Callable[[str], None]


@dataclass(frozen=True)
class DiagnosisOptions:
    """What the user chose."""

    preprocessing: str = "parallel"
    cutoff: float | None = None
    """[Hz]; None: chosen from the spectra."""
    only: tuple[str, ...] = ()
    """Effects to add in this order, and no others; empty: whichever explain most."""


@dataclass(frozen=True, eq=False)
class DiagnosisInputs:
    """What a diagnosis begins with."""

    split: SplitData
    observable: Mapping[str, Effect]
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, and why."""
    excerpt_share: float | None
    """Share of the recordings that is looked at, where they are too long for all."""

    def initial_model(self, library: Mapping[str, Effect], model: Model | None = None) -> tuple[Composition, Floats]:
        """The bare mechanism, or `model`, with where to begin its parameters (K,).

        Raises:
            BadInput: the model is of another rig.
        """
        path = self.split.predictors[0].course.path
        if model is None:
            bare = Composition(path.mechanism, path.rig)
            return bare, np.zeros(len(bare.named))
        refuse_other_rig(model, self.split.datasets[0].recording)
        return composition_of(model, path.rig, library)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The answer, with all that it was found from."""

    split: SplitData
    library: Mapping[str, Effect]
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, and why."""
    selection: Selection
    unexplained: UnexplainedResidual
    learned: NonparametricFit | None
    """Curves for the remainder, where there are any."""
    excerpt_share: float | None
    """Share of the recordings that was looked at, where they were too long for all."""
    forced: bool = False
    """Whether the effects were asked for, and no others were tried."""


def diagnose(
    files: Sequence[Path],
    validate: Sequence[Path],
    library: Mapping[str, Effect],
    options: DiagnosisOptions,
    progress: StatusCallback = lambda what: None,
    initial_model: Model | None = None,
) -> Diagnosis:
    """Find out which effects of the `library` the base model lacks in the recordings `files`.

    validate: recordings of other motions, which no fit sees; without any, phase segments are held out.
    model: with whose effects to begin.

    Raises:
        BadInput: a recording cannot be used, they are not of the same rig, or an effect that was asked for does not
            exist or show.
    """
    _refuse(options.only, library, {})
    asked = prepare_inputs(files, validate, library, options)
    _refuse(options.only, library, asked.unobservable)
    material, climber = asked.split, Selector(asked.split, asked.observable, progress)
    beginning = asked.initial_model(library, initial_model)
    ladder = _ladder(climber, beginning, options)
    told = material.without_saturated_rows(ladder.steps[-1].model.solution, ladder.noise_floor.rms)
    if told is not material:
        material, climber = told, Selector(told, asked.observable, progress)
        ladder = _ladder(climber, beginning, options)
    progress("what remains")
    left = estimate_unexplained(material, ladder.steps[-1].model, ladder.noise_floor)
    stand_in = None
    if left.significant:
        ladder = ladder if options.only else remove_imitations(material, climber, ladder)
        stand_in = fit_curves(material, ladder.steps[-1].model)
        known = stand_in.dependences if stand_in and stand_in.supported else None
        left = estimate_unexplained(material, ladder.steps[-1].model, ladder.noise_floor, known)
    return Diagnosis(material, library, asked.unobservable, ladder, left, stand_in, asked.excerpt_share, bool(options.only))


def _refuse(names: Sequence[str], library: Mapping[str, Effect], unobservable: Mapping[str, str]) -> None:
    for name in names:
        if name not in library:
            raise BadInput(f"effect: one of {', '.join(sorted(library))} expected, '{name}' found; correct it")
        if name in unobservable:
            raise BadInput(
                f"effect: one that these recordings can show expected, '{name}' found: {unobservable[name]}"
            )


def _ladder(climber: Selector, beginning: tuple[Composition, Floats], choices: DiagnosisOptions) -> Selection:
    return climber.select_forced(*beginning, choices.only) if choices.only else climber.select(*beginning)


def prepare_inputs(
    files: Sequence[Path], validate: Sequence[Path], library: Mapping[str, Effect], options: DiagnosisOptions
) -> DiagnosisInputs:
    """What there is to work with: recordings as `diagnose` takes them.

    Raises:
        BadInput: a recording cannot be used, or they are not of the same rig.
    """
    refuse_the_same_twice((*files, *validate))
    recordings = [read(path) for path in (*files, *validate)]
    refuse_different_rigs(recordings)
    refuse_overlap(recordings)
    courses, share = _courses(recordings, options)
    train, held = courses[: len(files)], courses[len(files) :]
    material = split_recordings(list(chain.from_iterable(train)), list(chain.from_iterable(held)))
    return DiagnosisInputs(material, *_offered(recordings[0], library), share)


def _courses(recordings: Sequence[Recording], choices: DiagnosisOptions) -> tuple[list[list[Course]], float | None]:
    """The courses of each recording, all at the lowest cut-off that any of them asks for."""
    cut = [excerpts(recording) for recording in recordings]
    choices = replace(choices, cutoff=choices.cutoff or _cutoff(recordings))
    courses = [
        [prepare(part.recording, choices.preprocessing, choices.cutoff, part.start) for part in parts]
        for parts in cut
    ]
    lowest = min(course.prepared.bandwidth for group in courses for course in group)
    same = [
        [
            course
            if course.prepared.bandwidth == lowest
            else prepare(course.recording, choices.preprocessing, lowest, course.start)
            for course in group
        ]
        for group in courses
    ]
    kept = sum(len(part.recording.time) for parts in cut for part in parts)
    whole = sum(len(recording.time) for recording in recordings)
    return same, None if kept == whole else kept / whole


def _cutoff(recordings: Sequence[Recording]) -> float:
    """[Hz] A low-pass that leaves less of the encoders' noise than a fit would bear: effects are small."""
    found = []
    for recording in recordings:
        samples = sample(excerpts(recording)[0].recording)
        position, torque = samples.position, samples.torque
        spectra = cutoff.spectra(position, torque, samples.rate)
        usual = cutoff.decide(spectra, samples.rate).hz
        fine = min(max(cutoff.decide(spectra, samples.rate, MAX_ENCODER_NOISE).hz, MIN_BANDWIDTH), usual)
        found.append(usual if _between(torque, samples.rate, fine, usual) > MAX_TORQUE_LOSS else fine)
    return min(found)


def _between(torque: Floats, rate: float, low: float, high: float) -> float:
    """Share of the RMS of `torque` (n, dof) up to `high` that lies above `low` [Hz], of the joint with most."""
    if low >= high:
        return 0.0
    more, less = (filters.convolve(torque, filters.low_pass(hz, rate)) for hz in (high, low))
    share: Floats = np.nanstd(more - less, axis=0) / np.maximum(np.nanstd(more, axis=0), _TINY)
    return float(np.nanmax(share))


def _offered(recording: Recording, library: Mapping[str, Effect]) -> tuple[dict[str, Effect], dict[str, str]]:
    """The effects that such a recording may show, and why it cannot show the others of this mechanism."""
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

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
from ident.diagnosis.misspecification_check import without_imitations
from ident.diagnosis.nonparametric_fit import StandIn, learn
from ident.diagnosis.split_data import Material, gather
from ident.diagnosis.steps import Ladder
from ident.diagnosis.stepwise_selection import Climber
from ident.diagnosis.unexplained_residual import Remainder, remainder
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition
from ident.identification.identify import refuse_different_rigs, refuse_overlap, refuse_the_same_twice
from ident.identification.model import Model
from ident.identification.prediction import composition_of, refuse_other_rig
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording

TOLERATED = 0.004
"""Encoder noise in the torque, over the torque: the smallest effects that matter are not much larger."""
LEAST_BANDWIDTH = 10.0
"""Where coarse encoders ask for less than this, friction at reversals counts for more [Hz]."""

_TINY = 1e-12
RICH = 0.1
"""Share of the torque, in RMS, that a low-pass must not take away because of encoder noise: ripple would be gone."""

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Choices:
    """What the user chose."""

    preprocessing: str = "parallel"
    cutoff: float | None = None
    """[Hz]; None: chosen from the spectra."""
    only: tuple[str, ...] = ()
    """Effects to add in this order, and no others; empty: whichever explain most."""


@dataclass(frozen=True, eq=False)
class Question:
    """What a diagnosis begins with."""

    material: Material
    offered: Mapping[str, Effect]
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, and why."""
    excerpt: float | None
    """Share of the recordings that is looked at, where they are too long for all."""

    def beginning(self, library: Mapping[str, Effect], model: Model | None = None) -> tuple[Composition, Floats]:
        """The bare mechanism, or `model`, with where to begin its parameters (K,).

        Raises:
            BadInput: the model is of another rig.
        """
        path = self.material.evaluators[0].course.path
        if model is None:
            bare = Composition(path.mechanism, path.rig)
            return bare, np.zeros(len(bare.named))
        refuse_other_rig(model, self.material.datasets[0].recording)
        return composition_of(model, path.rig, library)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The answer, with all that it was found from."""

    material: Material
    library: Mapping[str, Effect]
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, and why."""
    ladder: Ladder
    remainder: Remainder
    stand_in: StandIn | None
    """Curves for the remainder, where there are any."""
    excerpt: float | None
    """Share of the recordings that was looked at, where they were too long for all."""
    by_hand: bool = False
    """Whether the effects were asked for, and no others were tried."""


def diagnose(
    files: Sequence[Path],
    validate: Sequence[Path],
    library: Mapping[str, Effect],
    choices: Choices,
    progress: Progress = lambda what: None,
    model: Model | None = None,
) -> Diagnosis:
    """Find out which effects of the `library` the base model lacks in the recordings `files`.

    validate: recordings of other motions, which no fit sees; without any, phase segments are held out.
    model: with whose effects to begin.

    Raises:
        BadInput: a recording cannot be used, they are not of the same rig, or an effect that was asked for does not
            exist or show.
    """
    _refuse(choices.only, library, {})
    asked = question(files, validate, library, choices)
    _refuse(choices.only, library, asked.unobservable)
    material, climber = asked.material, Climber(asked.material, asked.offered, progress)
    beginning = asked.beginning(library, model)
    ladder = _ladder(climber, beginning, choices)
    told = material.faithful(ladder.rungs[-1].state.solution, ladder.floor.rms)
    if told is not material:
        material, climber = told, Climber(told, asked.offered, progress)
        ladder = _ladder(climber, beginning, choices)
    progress("what remains")
    left = remainder(material, ladder.rungs[-1].state, ladder.floor)
    stand_in = None
    if left.unexplained:
        ladder = ladder if choices.only else without_imitations(material, climber, ladder)
        stand_in = learn(material, ladder.rungs[-1].state)
        known = stand_in.dependences if stand_in and stand_in.holds else None
        left = remainder(material, ladder.rungs[-1].state, ladder.floor, known)
    return Diagnosis(material, library, asked.unobservable, ladder, left, stand_in, asked.excerpt, bool(choices.only))


def _refuse(names: Sequence[str], library: Mapping[str, Effect], unobservable: Mapping[str, str]) -> None:
    for name in names:
        if name not in library:
            raise BadInput(f"effect: one of {', '.join(sorted(library))} expected, '{name}' found; correct it")
        if name in unobservable:
            raise BadInput(
                f"effect: one that these recordings can show expected, '{name}' found: {unobservable[name]}"
            )


def _ladder(climber: Climber, beginning: tuple[Composition, Floats], choices: Choices) -> Ladder:
    return climber.by_hand(*beginning, choices.only) if choices.only else climber.climb(*beginning)


def question(
    files: Sequence[Path], validate: Sequence[Path], library: Mapping[str, Effect], choices: Choices
) -> Question:
    """What there is to work with: recordings as `diagnose` takes them.

    Raises:
        BadInput: a recording cannot be used, or they are not of the same rig.
    """
    refuse_the_same_twice((*files, *validate))
    recordings = [read(path) for path in (*files, *validate)]
    refuse_different_rigs(recordings)
    refuse_overlap(recordings)
    courses, share = _courses(recordings, choices)
    train, held = courses[: len(files)], courses[len(files) :]
    material = gather(list(chain.from_iterable(train)), list(chain.from_iterable(held)))
    return Question(material, *_offered(recordings[0], library), share)


def _courses(recordings: Sequence[Recording], choices: Choices) -> tuple[list[list[Course]], float | None]:
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
        fine = min(max(cutoff.decide(spectra, samples.rate, TOLERATED).hz, LEAST_BANDWIDTH), usual)
        found.append(usual if _between(torque, samples.rate, fine, usual) > RICH else fine)
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

"""A mechanism with effects whose shapes and distortions are settled, as a linear model for estimators.

Around the vector x that least squares found, reported torque = offset + columns . linear parameters: exact where no
effect stands between the torque and what is reported of it, else to first order.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ident.data.dataset import Dataset
from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import holds_torque
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Effect, Signal
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation import chunks
from ident.estimation.nonlinear_fit import nonlinear_least_squares
from ident.estimation.predicted_torque import TorquePredictor
from recordings.errors import BadInput
from recordings.recording import Floats, Recording


@dataclass(frozen=True, eq=False)
class LinearizedModel:
    """A composition with a vector x (K,), as a mechanism whose parameters are the linear ones."""

    structure: ModelStructure
    x: Floats

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the mechanism, and the coefficients of additive effects."""
        own = self.structure.mechanism.parameters
        added = [one for one in self.structure.parameters if one.linear and one.term >= 0]
        return *own, *(Parameter(one.name, one.unit, one.meaning) for one in added)

    @property
    def pointwise(self) -> bool:
        """Effects may remember."""
        return not self.structure.terms

    def regressor(self, motion: Motion) -> Floats:
        """(n, dof, k) of the mechanism; zero for effects, which need more than a motion: see `dataset`."""
        own = self.structure.mechanism.regressor(motion)
        return np.pad(own, ((0, 0), (0, 0), (0, len(self.parameters) - own.shape[2])))

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """The manufacturer's model knows no effects."""
        return self.structure.mechanism.nominal_torque(motion)

    def out_of_range(self, parameters: Floats) -> list[str]:
        """Sentences about coefficients among the `parameters` (k,) that no real machine has."""
        named = [one for one in self.structure.parameters if one.linear]
        return [
            f"{one.name} = {value:.4g} {one.unit} is outside of its physical range ({one.lower:g} to {one.upper:g}): "
            f"evidence against {one.name.partition('.')[0]}."
            for one, value in zip(named, parameters, strict=True)
            if one.term >= 0 and not one.lower <= value <= one.upper
        ]

    def dataset(self, course: PreparedRecording) -> Dataset:
        """The rows of `course`, with the linear parameters' columns and what does not depend on them."""
        torque, columns = chunks.linearized(course, self.structure, self.x)
        offset = torque - columns @ self.x[self.structure.linear]
        if not any(isinstance(term.effect, Signal) for term in self.structure.terms):
            offset = np.zeros_like(offset)  # exactly, whatever the sums' last bits
        known = np.isfinite(columns).all(axis=2) & np.isfinite(offset)
        measured = np.where(known, course.dataset.torque, np.nan)
        return replace(course.dataset, regressor=columns, offset=offset, torque=measured)


def parse_terms(choices: Sequence[str], library: Mapping[str, Effect], recording: Recording) -> tuple[Term, ...]:
    """The effects that a user chose, each as NAME, on all joints, or as NAME:1,3.

    Raises:
        BadInput: there is no such effect, it is named twice, its joints are not there, or such a recording cannot
            show it.
    """
    found: list[Term] = []
    for choice in choices:
        term = _term(choice, library, recording)
        if any(term.name == other.name for other in found):
            raise BadInput(f"every effect once expected, '{term.name}' found twice; leave one out")
        found.append(term)
    return tuple(found)


def _term(choice: str, library: Mapping[str, Effect], recording: Recording) -> Term:
    rig = recording.rig
    name, _, joints = choice.partition(":")
    if name not in library:
        raise BadInput(f"effect: one of {', '.join(sorted(library))} expected, '{name}' found; see `ident effects`")
    effect = library[name]
    if rig.mechanism not in effect.mechanisms:
        raise BadInput(
            f"effect {name}: mechanism {' or '.join(effect.mechanisms)} expected, {rig.mechanism} found; leave it out"
        )
    why = effect.unobservable(rig, holds_torque(recording))
    if why:
        raise BadInput(f"effect {name} cannot be seen in such a recording: {why} Leave it out")
    return Term(name, effect, _joints(name, joints, rig.dof))


def _joints(name: str, joints: str, dof: int) -> tuple[int, ...]:
    if not joints:
        return tuple(range(dof))
    numbers = joints.split(",")
    if not all(number.isdigit() and 1 <= int(number) <= dof for number in numbers) or len(set(numbers)) < len(
        numbers
    ):
        raise BadInput(f"effect {name}: joints 1 to {dof}, such as {name}:1,2, expected, '{joints}' found")
    return tuple(int(number) - 1 for number in numbers)


def fit_shape_parameters(courses: Sequence[PreparedRecording], chosen: Sequence[Term]) -> LinearizedModel:
    """The mechanism of `courses` with the effects `chosen`, whose shapes and distortions fit the recordings best.

    Effect by effect, from each place where the search for it may begin; then all together.
    """
    evaluators = [TorquePredictor(course) for course in courses]
    weights = [np.where(course.usable, 1.0, 0.0) for course in courses]
    path = courses[0].as_recorded
    bare = ModelStructure(path.mechanism, path.rig)
    solution = nonlinear_least_squares(evaluators, bare, np.zeros(len(bare.parameters)), weights)
    for term in chosen:
        composition = solution.structure.with_term(term)
        view = evaluators[0].effect_inputs(
            evaluators[0].corrected_motion(solution.structure, solution.x), solution.structure.load_parameters(solution.x)
        )
        residual = solution.residuals[0]
        starts = list(_starts(term, [*_suggested(term.effect, view, residual, courses[0])]))
        tried = [nonlinear_least_squares(evaluators, composition, np.concatenate([solution.x, start]), weights) for start in starts]
        solution = min(tried, key=lambda one: one.loss)
    return LinearizedModel(solution.structure, solution.x)


def _suggested(effect: Effect, view: EffectInputs, residual: Floats, course: PreparedRecording) -> list[Floats]:
    if effect.suggest is None:
        return []
    found = effect.suggest(view.decimated(course.preprocessed.decimation), residual)
    return [np.array([shapes[shape.name] for shape in effect.shapes]) for shapes in found]


def _starts(term: Term, suggested: Sequence[Floats]) -> list[Floats]:
    """(own + shapes,) vectors from which to search."""
    shapes = [np.array(one, float) for one in product(*(shape.initial_guesses for shape in term.effect.shapes))]
    shapes += suggested
    if isinstance(term.effect, Additive):
        own = [np.zeros(term.instances * len(term.local_parameters))]
    else:
        own = [np.tile(one, term.instances) for one in product(*(quantity.initial_guesses for quantity in term.local_parameters))]
    return [np.concatenate(pair) for pair in product(own, shapes)]

"""A mechanism with effects whose nonlinear parameters are fixed, as a linear model for estimators.

Around the least-squares solution x, reported torque = offset + columns . linear parameters. This is exact without
signal effects, else accurate to first order.
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
    """A model structure linearized at parameters x (K,), as a mechanism with the linear parameters."""

    structure: ModelStructure
    x: Floats

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the mechanism and coefficients of additive effects."""
        mechanism = self.structure.mechanism.parameters
        coefficients = [entry for entry in self.structure.parameters if entry.linear and entry.term >= 0]
        return *mechanism, *(Parameter(entry.name, entry.unit, entry.meaning) for entry in coefficients)

    @property
    def pointwise(self) -> bool:
        """False with effects, which may have an internal state."""
        return not self.structure.terms

    def regressor(self, motion: Motion) -> Floats:
        """(n, dof, k) columns of the mechanism; zero for effects, which need more than a motion: see `dataset`."""
        columns = self.structure.mechanism.regressor(motion)
        return np.pad(columns, ((0, 0), (0, 0), (0, len(self.parameters) - columns.shape[2])))

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """Torque of the manufacturer's model, which has no effects."""
        return self.structure.mechanism.nominal_torque(motion)

    def out_of_range(self, parameters: Floats) -> list[str]:
        """Describe the coefficients among the `parameters` (k,) that are outside of their physical range."""
        entries = [entry for entry in self.structure.parameters if entry.linear]
        return [
            f"{entry.name} = {value:.4g} {entry.unit} is outside of its physical range "
            f"({entry.lower:g} to {entry.upper:g}): "
            f"evidence against {entry.name.partition('.')[0]}."
            for entry, value in zip(entries, parameters, strict=True)
            if entry.term >= 0 and not entry.lower <= value <= entry.upper
        ]

    def dataset(self, prepared: PreparedRecording) -> Dataset:
        """Rows of the recording with the columns of the linear parameters and the remaining torque as offset."""
        torque, columns = chunks.linearized(prepared, self.structure, self.x)
        offset = torque - columns @ self.x[self.structure.linear]
        if not any(isinstance(term.effect, Signal) for term in self.structure.terms):
            offset = np.zeros_like(offset)  # exactly zero, without rounding errors
        known = np.isfinite(columns).all(axis=2) & np.isfinite(offset)
        measured = np.where(known, prepared.dataset.torque, np.nan)
        return replace(prepared.dataset, regressor=columns, offset=offset, torque=measured)


def parse_terms(choices: Sequence[str], library: Mapping[str, Effect], recording: Recording) -> tuple[Term, ...]:
    """Convert the effects chosen by the user, NAME (all joints) or NAME:1,3 (some joints), to terms.

    Raises:
        BadInput: the effect does not exist, is named twice or is not observable in such a recording, or one of its
            joints does not exist.
    """
    terms: list[Term] = []
    for choice in choices:
        term = _parse_term(choice, library, recording)
        if any(term.name == previous.name for previous in terms):
            raise BadInput(f"every effect once expected, '{term.name}' found twice; leave one out")
        terms.append(term)
    return tuple(terms)


def _parse_term(choice: str, library: Mapping[str, Effect], recording: Recording) -> Term:
    rig = recording.rig
    name, _, joints = choice.partition(":")
    if name not in library:
        raise BadInput(f"effect: one of {', '.join(sorted(library))} expected, '{name}' found; see `ident effects`")
    effect = library[name]
    if rig.mechanism not in effect.mechanisms:
        raise BadInput(
            f"effect {name}: mechanism {' or '.join(effect.mechanisms)} expected, {rig.mechanism} found; leave it out"
        )
    reason = effect.unobservable(rig, holds_torque(recording))
    if reason:
        raise BadInput(f"effect {name} cannot be seen in such a recording: {reason} Leave it out")
    return Term(name, effect, _parse_joints(name, joints, rig.dof))


def _parse_joints(name: str, joints: str, dof: int) -> tuple[int, ...]:
    if not joints:
        return tuple(range(dof))
    numbers = joints.split(",")
    if not all(number.isdigit() and 1 <= int(number) <= dof for number in numbers) or len(set(numbers)) < len(
        numbers
    ):
        raise BadInput(f"effect {name}: joints 1 to {dof}, such as {name}:1,2, expected, '{joints}' found")
    return tuple(int(number) - 1 for number in numbers)


def fit_shape_parameters(recordings: Sequence[PreparedRecording], terms: Sequence[Term]) -> LinearizedModel:
    """Fit the shapes and signal parameters of the effects `terms` to the `recordings`, by nonlinear least squares.

    The effects are added one by one. For each one, the fit starts from all of its initial guesses, and the best
    result is kept. All parameters are fitted together in each step.
    """
    predictors = [TorquePredictor(prepared) for prepared in recordings]
    weights = [np.where(prepared.usable, 1.0, 0.0) for prepared in recordings]
    recorded = recordings[0].as_recorded
    bare = ModelStructure(recorded.mechanism, recorded.rig)
    solution = nonlinear_least_squares(predictors, bare, np.zeros(len(bare.parameters)), weights)
    for term in terms:
        structure = solution.structure.with_term(term)
        inputs = predictors[0].effect_inputs(
            predictors[0].corrected_motion(solution.structure, solution.x),
            solution.structure.load_parameters(solution.x),
        )
        residual = solution.residuals[0]
        initial_guesses = list(
            _initial_guesses(term, [*_suggested_shapes(term.effect, inputs, residual, recordings[0])])
        )
        candidates = [
            nonlinear_least_squares(predictors, structure, np.concatenate([solution.x, start]), weights)
            for start in initial_guesses
        ]
        solution = min(candidates, key=lambda candidate: candidate.loss)
    return LinearizedModel(solution.structure, solution.x)


def _suggested_shapes(
    effect: Effect, inputs: EffectInputs, residual: Floats, prepared: PreparedRecording
) -> list[Floats]:
    if effect.suggest is None:
        return []
    suggestions = effect.suggest(inputs.decimated(prepared.preprocessed.decimation), residual)
    return [np.array([shapes[shape.name] for shape in effect.shapes]) for shapes in suggestions]


def _initial_guesses(term: Term, suggested: Sequence[Floats]) -> list[Floats]:
    """Vectors (local parameters + shapes,) from which the fit starts."""
    shapes = [np.array(values, float) for values in product(*(shape.initial_guesses for shape in term.effect.shapes))]
    shapes += suggested
    if isinstance(term.effect, Additive):
        local = [np.zeros(term.instances * len(term.local_parameters))]
    else:
        local = [
            np.tile(values, term.instances)
            for values in product(*(quantity.initial_guesses for quantity in term.local_parameters))
        ]
    return [np.concatenate(pair) for pair in product(local, shapes)]

"""A model from a file, applied to recordings: what it says the torque should have been."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ident.data.dataset import Dataset, build
from ident.data.prepared_recording import prepare
from ident.dynamics import mechanisms
from ident.dynamics.effects.base import Effect, Signal
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.structure import ModelStructure, ParameterEntry, Term
from ident.estimation import chunks
from ident.identification.model import EffectTerm, Model
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording
from recordings.rig import Geometry, Rig, Torque


@dataclass(frozen=True, eq=False)
class Prediction:
    """One recording, preprocessed as the model's own were, and the torque that the model computes for it."""

    dataset: Dataset
    computed: Floats
    """(m, dof) [N m or N]."""

    @property
    def residual(self) -> Floats:
        """(m, dof) measured minus computed; NaN where a sample is not to be used."""
        left: Floats = self.dataset.torque - self.computed
        return left


def predict(model: Model, files: Sequence[Path], library: Mapping[str, Effect]) -> tuple[Prediction, ...]:
    """Apply `model` to the recordings `files`; `library`: of effects.

    Raises:
        BadInput: a recording cannot be used, or is of another rig than the model.
    """
    recordings = [read(path) for path in files]
    for recording in recordings:
        check_model_rig(model, recording)
    cutoff = model.preprocessing.bandwidth if model.preprocessing.cutoff else None
    if model.form:
        mechanism = mechanisms.create(recordings[0].rig, model.form)
        values = _values(model, mechanism.parameters)
        datasets = [build(recording, mechanism, model.preprocessing.name, cutoff) for recording in recordings]
        return tuple(Prediction(dataset, dataset.predicted_torque(values)) for dataset in datasets)
    composition, x = structure_of(model, recordings[0].rig, library)
    # One after the other: all that a long recording is prepared from need not be kept.
    courses = (prepare(recording, model.preprocessing.name, cutoff) for recording in recordings)
    return tuple(Prediction(course.dataset, chunks.torque(course, composition, x)) for course in courses)


def structure_of(model: Model, rig: Rig, library: Mapping[str, Effect]) -> tuple[ModelStructure, Floats]:
    """The mechanism with its effects that `model` describes, and their parameters (K,).

    Raises:
        BadInput: the model holds effects or parameters that this software does not know.
    """
    terms = []
    for term in model.terms or [EffectTerm(name=name, joints=_all(rig)) for name in model.effects]:
        if term.name not in library:
            raise BadInput(
                f"effect {term.name}: one of the library or of an effect file expected, as the model has it, none "
                "found; give --effect-file"
            )
        terms.append(Term(term.name, library[term.name], tuple(joint - 1 for joint in term.joints)))
    composition = ModelStructure(mechanisms.create(rig), rig, tuple(terms))
    linear = [one for one in composition.parameters if one.linear]
    x = np.zeros(len(composition.parameters))
    x[composition.linear] = _values(model, linear)
    for index, kept in enumerate(model.terms):
        x[composition.parameter_mask(index) & ~composition.linear] = _settled(terms[index], kept)
    return composition, x


def effect_terms(structure: ModelStructure, x: Floats) -> tuple[EffectTerm, ...]:
    """The effects of `composition` with what of `x` (K,) is not among a model's parameters."""
    return tuple(_entry(structure, index, x) for index in range(len(structure.terms)))


def _entry(composition: ModelStructure, index: int, x: Floats) -> EffectTerm:
    term = composition.terms[index]
    shapes = zip(term.effect.shapes, composition.shape_values(index, x).tolist(), strict=True)
    own = composition.local_values(index, x) if isinstance(term.effect, Signal) else ()
    return EffectTerm(
        name=term.name,
        joints=tuple(joint + 1 for joint in term.joints),
        shapes={shape.name: value for shape, value in shapes},
        parameters=tuple(
            dict(zip((one.name for one in term.local_parameters), row.tolist(), strict=True)) for row in own
        ),
    )


def _settled(term: Term, kept: EffectTerm) -> list[float]:
    """What is searched for, owner by owner, then the shapes."""
    try:
        own = [row[one.name] for row in kept.parameters for one in term.local_parameters]
        return [*own, *(kept.shapes[shape.name] for shape in term.effect.shapes)]
    except KeyError as error:
        raise BadInput(
            f"effect {term.name}: a value of {error} expected in the model, none found; fit it again"
        ) from None


def _values(model: Model, parameters: Sequence[ParameterEntry | Parameter]) -> Floats:
    expected = [parameter.name for parameter in parameters]
    found = [parameter.name for parameter in model.parameters]
    if found != expected:
        raise BadInput(
            f"parameters {', '.join(expected)} expected in the model, {', '.join(found)} found; fit it again"
        )
    return np.array([parameter.value for parameter in model.parameters])


def _all(rig: Rig) -> tuple[int, ...]:
    return tuple(range(1, rig.dof + 1))


def check_model_rig(model: Model, recording: Recording) -> None:
    """Raise BadInput where `recording` is of another machine than `model`."""
    rig = recording.rig
    expected = _flat(model.mechanism, model.effort_units, model.torque, model.geometry)
    found = _flat(rig.mechanism, rig.effort_units, rig.torque, rig.geometry if model.geometry else None)
    for what in expected:
        if expected[what] != found[what]:
            raise BadInput(
                f"a recording of the rig that was identified expected: {what} is {expected[what]} in the model, "
                f"{found[what]} in {recording.path.name}; fit a model to it"
            )


def _flat(mechanism: str, units: tuple[str, ...], torque: Torque, geometry: Geometry | None) -> dict[str, object]:
    sections = {"torque": torque, **({"geometry": geometry} if geometry else {})}
    fields = {f"{name}.{key}": value for name, section in sections.items() for key, value in section}
    return {"mechanism": mechanism, "the effort's unit": ", ".join(units), **fields}

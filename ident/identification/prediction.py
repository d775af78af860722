"""Predict the torque of recordings by a model from a file."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.compatibility import first_difference, of_one_set_up, refuse_unknown_payload, remedy
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data.samples import is_relative
from ident.data_problems import examined
from ident.dynamics import mechanisms
from ident.dynamics.effects import unknown_payload
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import names as built_in
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.structure import ModelStructure, ParameterEntry, Term
from ident.estimation import chunks
from ident.estimation.linear_fit import SEARCH_FACTOR
from ident.identification.model_file import EffectTerm, FittedParameter, ModelFile
from ident.identification.saved_formula import saved_formula
from ident.uncertainty.assessment import ParameterUncertainty
from recordings.data_problems import DataProblem
from recordings.errors import BadInput, told
from recordings.reader import Source, opened
from recordings.recording import Bools, Floats, Recording
from recordings.rig import Geometry, Rig, Torque
from recordings.urdf import Chain, Payload


@dataclass(frozen=True, eq=False)
class Prediction:
    """One recording, preprocessed as the model's training data, and the torque that the model predicts for it."""

    prepared: PreparedRecording
    computed: Floats
    """(m, dof) [N m or N]."""
    scored: Bools | None = None
    """(m, dof) rows that enter errors; None: all usable ones."""
    problems: tuple[DataProblem, ...] = ()
    """What cannot be right about the recording, but does not keep from using it."""

    @property
    def residual(self) -> Floats:
        """(m, dof) measured minus computed torque; NaN where a sample is not usable."""
        return self.prepared.torque - self.computed

    @property
    def scored_residual(self) -> Floats:
        """(m, dof) `residual`; NaN also where a row is not scored."""
        return self.residual if self.scored is None else np.where(self.scored, self.residual, np.nan)


def predict(
    model: ModelFile, files: Sequence[Source], library: Mapping[str, Effect], accept: Collection[str] = ()
) -> tuple[Prediction, ...]:
    """Apply `model` to the recordings `files`; `library` holds the effects by name.

    accept: kinds of data problems in spite of which they are used, beside those that the model was fitted with.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, or is of another rig than the model.
    """
    recordings = [opened(source) for source in files]
    if unknown_payload.NAME not in {term.name for term in model.terms}:
        refuse_unknown_payload(recordings)
    recordings = [of_one_set_up(each, model.payload) for each in recordings]
    for recording in recordings:
        check_model_rig(model, recording)
    cutoff = model.preprocessing.bandwidth if model.preprocessing.cutoff else None
    structure, x = structure_of(model, recordings[0].rig, library)

    def prepared(recordings: Sequence[Recording]) -> list[list[PreparedRecording]]:
        return [[prepare(each, model.preprocessing.name, cutoff, form=model.form)] for each in recordings]

    usable = examined(recordings, prepared, {*accept, *(problem.kind for problem in model.data_problems)})
    return tuple(
        Prediction(excerpt, chunks.torque(excerpt, structure, x), problems=each.problems)
        for each in usable
        for excerpt in each.excerpts
    )


def structure_of(model: ModelFile, rig: Rig, library: Mapping[str, Effect]) -> tuple[ModelStructure, Floats]:
    """Build the mechanism with effects that `model` describes, and its parameters (K,).

    Raises:
        BadInput: the model contains effects or parameters that this software does not know.
    """
    if model.form:
        mechanism = mechanisms.create(rig, model.form)
        return ModelStructure(mechanism, rig), _values(model, mechanism.parameters)
    terms = tuple(
        Term(term.name, _effect_of(term, library), tuple(joint - 1 for joint in term.joints)) for term in model.terms
    )
    structure = ModelStructure(mechanisms.create(rig), rig, terms)
    linear = [parameter for parameter in structure.parameters if parameter.linear]
    x = np.zeros(len(structure.parameters))
    x[structure.linear] = _values(model, linear)
    for index, saved in enumerate(model.terms):
        places, values = structure.parameter_mask(index) & ~structure.linear, _searched_values(terms[index], saved)
        if places.sum() != len(values):
            raise BadInput(
                f"effect {saved.name}: {places.sum()} values found by search expected in the model, {len(values)} "
                "found; fit it again"
            )
        x[places] = values
    return structure, x


def _effect_of(term: EffectTerm, library: Mapping[str, Effect]) -> Effect:
    """The effect of a `term`: of the library, or by the formula that the model holds."""
    if term.name == unknown_payload.NAME:
        return unknown_payload.of_unknown_place if term.shapes else unknown_payload.of_known_place
    if term.name not in library:
        if term.formula is None:
            raise BadInput(
                f"effect {term.name} of the model: an effect of the library or of an effect file expected, none "
                f"found, and the model holds no formula of it; give {told('--effect-file', 'effect_files')}"
            )
        return term.formula.effect(term.name)
    effect = library[term.name]
    found = saved_formula(effect)
    if term.formula and (found is None or found.digest != term.formula.digest):
        raise BadInput(
            f"effect {term.name} of the model: its formula {' + '.join(term.formula.columns)} expected, another one "
            f"found under this name; leave out {told('--effect-file', 'effect_files')}, or drop the other one: "
            f"ident effects --drop {term.name}"
        )
    return effect


def searched_parameters(
    structure: ModelStructure, x: Floats, uncertainties: Sequence[ParameterUncertainty]
) -> tuple[FittedParameter, ...]:
    """Those values of `x` (K,) that are not among the model's parameters, with what is known of each; or nothing."""
    entries = [(structure.parameters[i], x[i]) for i in np.flatnonzero(structure.searched)]
    unknown = [ParameterUncertainty()] * (len(entries) - len(uncertainties))
    return tuple(
        FittedParameter(
            name=entry.name,
            value=float(value),
            unit=entry.unit,
            lower=entry.lower if np.isfinite(entry.lower) else -SEARCH_FACTOR * abs(float(value)),
            upper=entry.upper if np.isfinite(entry.upper) else SEARCH_FACTOR * abs(float(value)),
            at_bound=False,
            paper_value=float(value),
            meaning=entry.meaning,
            **known.model_dump(),
        )
        for (entry, value), known in zip(entries, (*uncertainties, *unknown), strict=True)
    )


def effect_terms(structure: ModelStructure, x: Floats) -> tuple[EffectTerm, ...]:
    """Effects of `structure`, with those values of `x` (K,) that are not among the model's parameters."""
    return tuple(_effect_term(structure, index, x) for index in range(len(structure.terms)))


def _effect_term(structure: ModelStructure, index: int, x: Floats) -> EffectTerm:
    term = structure.terms[index]
    shapes = zip(_shape_names(term), structure.shape_values(index, x).tolist(), strict=True)
    rows = structure.local_values(index, x) if not term.effect.linear else ()
    return EffectTerm(
        name=term.name,
        joints=tuple(joint + 1 for joint in term.joints),
        shapes=dict(shapes),
        parameters=tuple(
            dict(zip((parameter.name for parameter in term.local_parameters), row.tolist(), strict=True))
            for row in rows
        ),
        formula=None if term.name in built_in() else saved_formula(term.effect),
    )


def _searched_values(term: Term, saved: EffectTerm) -> list[float]:
    """Values found by search: parameters of a signal effect, instance by instance, then the shape parameters."""
    try:
        local_values = [row[parameter.name] for row in saved.parameters for parameter in term.local_parameters]
        return [*local_values, *(saved.shapes[name] for name in _shape_names(term))]
    except KeyError as error:
        raise BadInput(
            f"effect {term.name}: a value of {error} expected in the model, none found; fit it again"
        ) from None


def _shape_names(term: Term) -> list[str]:
    """Names of the term's shapes, with the number of the joint where each joint has its own."""
    joints = [str(joint + 1) for joint in term.joints] if term.effect.local_shapes else [""]
    return [f"{shape.name}{joint}" for joint in joints for shape in term.effect.shapes]


def _values(model: ModelFile, parameters: Sequence[ParameterEntry | Parameter]) -> Floats:
    expected = [parameter.name for parameter in parameters]
    actual = [parameter.name for parameter in model.parameters]
    if actual != expected:
        raise BadInput(
            f"parameters {', '.join(expected)} expected in the model, {', '.join(actual)} found; fit it again"
        )
    return np.array([parameter.value for parameter in model.parameters])


def check_model_rig(model: ModelFile, recording: Recording) -> None:
    """Check that `recording` is of the same rig as `model`; known gains of the torque may be its own.

    Raises:
        BadInput: a physical property of the rig differs.
    """
    sentence = f"a recording of the identified rig expected: {{}} in {recording.path.name}"
    known = not (model.relative or is_relative(recording))
    check_same_machine(model, recording.rig, sentence, own_gains=known)


def check_same_machine(model: ModelFile, rig: Rig, sentence: str, *, own_gains: bool = False) -> None:
    """Check that `rig` has the mechanism, the geometry and the torque map of `model`.

    sentence: of the error, with {} for what differs. own_gains: whether the gains of the torque may differ.

    Raises:
        BadInput: a physical property of the rig differs.
    """
    expected = _rig_properties(
        model.mechanism, model.effort_units, model.torque, model.geometry, model.robot, model.payload
    )
    actual = _rig_properties(
        rig.mechanism,
        rig.effort_units,
        rig.torque,
        rig.geometry if model.geometry else None,
        model.robot and rig.chain,
        rig.payload,
    )
    if name := first_difference(expected, actual, own_gains=own_gains):
        difference = f"{name} is {expected[name]} in the model, {actual[name]}"
        raise BadInput(f"{sentence.format(difference)}; {remedy(name, 'fit a model to it')}")


def _rig_properties(
    mechanism: str,
    units: tuple[str, ...],
    torque: Torque,
    geometry: Geometry | None,
    robot: Chain | None,
    payload: Payload | None,
) -> dict[str, object]:
    sections = {"torque": torque, **({"geometry": geometry} if geometry else {})}
    fields = {f"{name}.{key}": value for name, section in sections.items() for key, value in section}
    described = {"mechanism": mechanism, "the effort's unit": ", ".join(units), "payload": payload}
    return {**described, **fields, **(robot.properties if robot else {})}

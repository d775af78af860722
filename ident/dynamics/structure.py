"""Model structure: a mechanism with effects, and all their parameters in one vector."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs, Masses
from ident.dynamics.effects import unknown_payload
from ident.dynamics.effects.base import Additive, Effect, Quantity, Shapes, Signal, Values
from ident.dynamics.effects.reading import PositionCorrection
from ident.dynamics.mechanisms import Parameter, RigidMechanism
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.term import Term as Term
from recordings.recording import Bools, Floats, Ints
from recordings.rig import Rig

Report = Callable[[Floats, EffectInputs], Floats]
"""Computes the reported torque (n, dof) from the true one."""


@dataclass(frozen=True)
class ParameterEntry:
    """One entry of the parameter vector of a model structure."""

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    term: int
    """Index of the term that it belongs to; -1: the mechanism."""
    linear: bool
    """True if the torque is linear in it."""
    free: bool
    """False if a nonlinear fit must not change it, as for an index."""
    scale: float
    """Typical size: the smallest nonzero initial guess of a searched parameter, 1 for others."""
    usual: tuple[float, float] = (-np.inf, np.inf)
    """The values between which hardware usually stays, ends excluded."""


@dataclass(frozen=True)
class ModelStructure:
    """A mechanism of `rig` with `terms`."""

    mechanism: RigidMechanism
    rig: Rig
    terms: tuple[Term, ...] = ()

    def with_term(self, term: Term) -> "ModelStructure":
        """Return the structure with `term` appended."""
        return replace(self, terms=(*self.terms, term))

    def without_term(self, index: int) -> "ModelStructure":
        """Return the structure without the term `index`."""
        return replace(self, terms=self.terms[:index] + self.terms[index + 1 :])

    def with_effect(self, index: int, effect: Effect) -> "ModelStructure":
        """Return the structure with `effect`, which has the same parameters, in the term `index`."""
        term = replace(self.terms[index], effect=effect)
        return replace(self, terms=(*self.terms[:index], term, *self.terms[index + 1 :]))

    @property
    def bodies(self) -> Urdf | None:
        """The links, where fits allow only such that are bodies; else None."""
        return self.mechanism if isinstance(self.mechanism, Urdf) and self.mechanism.bound_to_bodies else None

    @cached_property
    def parameters(self) -> tuple[ParameterEntry, ...]:
        """Entries of the vector: the mechanism's, then of each term local parameters by instance, and shapes."""
        mechanism = [
            _mechanism_entry(parameter, replaced=replaced)
            for parameter, replaced in zip(self._mechanism_parameters, self._replaced, strict=True)
        ]
        return *mechanism, *(
            entry for index, term in enumerate(self.terms) for entry in self._term_parameters(index, term)
        )

    @cached_property
    def _mechanism_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the mechanism, with the meanings that they have beside the effects."""
        meanings = {name: meaning for term in self.terms for name, meaning in term.effect.meanings.items()}
        return tuple(
            replace(parameter, meaning=meanings.get(parameter.name, parameter.meaning))
            for parameter in self.mechanism.parameters
        )

    @cached_property
    def _replaced(self) -> Bools:
        """Mask (k,) of the mechanism's parameters in whose place an effect stands."""
        names = {f"{term.effect.replaces}{joint + 1}" for term in self.terms for joint in term.joints}
        return np.array([parameter.name in names for parameter in self.mechanism.parameters])

    def mechanism_columns(self, regressor: Floats) -> Floats:
        """Columns of the linear parameters of the mechanism, from its `regressor` (n, dof, k)."""
        return regressor[:, :, ~self._replaced] if self._replaced.any() else regressor

    def mechanism_values(self, linear: Floats) -> Floats:
        """Parameters (k,) of the mechanism, from the `linear` parameters (K_linear,); 0 for replaced ones."""
        kept = ~self._replaced
        values = np.zeros(len(kept))
        values[kept] = linear[: int(kept.sum())]
        return values

    def _term_parameters(self, index: int, term: Term) -> list[ParameterEntry]:
        linear = term.effect.linear
        joints = (None,) if term.effect.whole_robot else term.joints
        local = [
            self._parameter(index, term, quantity, joint, linear)
            for joint in joints
            for quantity in term.local_parameters
        ]
        shapes = [
            self._parameter(index, term, quantity, joint, False)
            for joint in (term.joints if term.effect.local_shapes else (None,))
            for quantity in term.effect.shapes
        ]
        return local + shapes

    @cached_property
    def term_names(self) -> tuple[str, ...]:
        """Names of the terms, those of repeated effects numbered: cogging, cogging#2."""
        names = [term.name for term in self.terms]
        repeats = [names[:index].count(name) for index, name in enumerate(names)]
        return tuple(f"{name}#{count + 1}" if count else name for name, count in zip(names, repeats, strict=True))

    def _parameter(
        self, index: int, term: Term, quantity: Quantity, joint: int | None, linear: bool
    ) -> ParameterEntry:
        name = f"{self.term_names[index]}.{quantity.name}"
        return ParameterEntry(
            name if joint is None else f"{name}{joint + 1}",
            quantity.unit_on(self.rig, joint or 0),
            quantity.meaning if joint is None else f"{quantity.meaning}, joint {joint + 1}",
            quantity.lower,
            quantity.upper,
            index,
            linear,
            linear or quantity.searched,
            min((abs(guess) for guess in quantity.initial_guesses if guess), default=1.0),
            quantity.usual_range,
        )

    @cached_property
    def linear_parameters(self) -> tuple[Parameter, ...]:
        """Parameters in which the torque is linear: the mechanism's, and coefficients of additive effects."""
        mechanism = zip(self._mechanism_parameters, self._replaced, strict=True)
        coefficients = [
            Parameter(
                entry.name,
                entry.unit,
                entry.meaning,
                nonnegative=self.terms[entry.term].effect.mandatory and entry.lower >= 0,  # a part of the machine
            )
            for entry in self.parameters
            if entry.linear and entry.term >= 0
        ]
        return *(parameter for parameter, replaced in mechanism if not replaced), *coefficients

    @cached_property
    def linear(self) -> Bools:
        """Mask (K,) of the entries in which the torque is linear."""
        return np.array([entry.linear for entry in self.parameters])

    @cached_property
    def searched(self) -> Bools:
        """(K,) True for the shapes and other values of effects that a search finds."""
        return np.array([entry.term >= 0 and not entry.linear for entry in self.parameters], bool)

    @cached_property
    def _entries(self) -> tuple[slice, ...]:
        """Entries of each term in the vector; those of the mechanism come last, for the index -1."""
        sizes = [term.instances * len(term.local_parameters) + len(term.shapes) for term in self.terms]
        ends = np.cumsum([len(self.mechanism.parameters), *sizes]).tolist()
        terms = [slice(first, end) for first, end in pairwise(ends)]
        return *terms, slice(0, ends[0])

    def parameter_mask(self, index: int) -> Bools:
        """Mask (K,) of the entries of the term `index`; -1: the mechanism."""
        mask = np.zeros(len(self.parameters), dtype=bool)
        mask[self._entries[index]] = True
        return mask

    def rigid_parameters(self, x: Floats) -> Floats:
        """Parameters (k or k + 1,) of the rigid model: the mechanism's, and the mass of the rods."""
        mandatory = [x[self._entries[index]] for index, term in enumerate(self.terms) if term.effect.mandatory]
        return np.concatenate([x[self._entries[-1]], *mandatory])

    def load_parameters(self, x: Floats) -> Floats:
        """Parameters of the load that effects depend on: those of the rigid model, and of the effects on the arms."""
        return np.concatenate([self.rigid_parameters(x), *(x[self._entries[index]] for index in self.arm_terms)])

    def load(self, load_parameters: Floats) -> tuple[Floats, Callable[[EffectInputs], Floats] | None, Masses]:
        """Split `load_parameters` into those of the rigid model and what computes the torque (n, dof) on the arms.

        They may be those of a structure that lacks the last terms, which then do not load the arms. The third is the
        unknown payload, whose torque that is a part of: its mass, and its place where that is a parameter.
        """
        x = np.zeros(len(self.parameters))
        rigid, on_arms = np.split(load_parameters, [len(self.rigid_parameters(x))])
        entries = np.concatenate([np.arange(len(x))[self._entries[index]] for index in (*self.arm_terms, -1)])
        x[entries[: len(on_arms)]] = on_arms
        loading = [index for index in self.arm_terms if self.local_values(index, x).any()]

        def arm_load(inputs: EffectInputs) -> Floats:
            torques = (self.terms[i].torque(self.columns(i, x, inputs), self.local_values(i, x)) for i in loading)
            return sum(torques, start=np.zeros_like(inputs.motion.position))

        payload = [index for index in loading if self.terms[index].name == unknown_payload.NAME]
        masses = tuple((self.local_values(i, x)[0, 0], tuple(self.shape_values(i, x))) for i in payload)
        return rigid, arm_load if loading else None, masses

    @cached_property
    def arm_terms(self) -> tuple[int, ...]:
        """Indices of the terms whose torque acts on the arms."""
        return tuple(index for index, _, effect in self.additive if effect.on_arm)

    def local_values(self, index: int, x: Floats) -> Floats:
        """Local parameters (instances, c) of the term `index` in the vector `x` (K,)."""
        term = self.terms[index]
        values = x[self._entries[index]]
        return values[: term.instances * len(term.local_parameters)].reshape(
            term.instances, len(term.local_parameters)
        )

    def shape_values(self, index: int, x: Floats) -> Floats:
        """Shapes (s,) of the term `index` in the vector `x` (K,)."""
        term = self.terms[index]
        return x[self._entries[index]][term.instances * len(term.local_parameters) :]

    def columns(self, index: int, x: Floats, inputs: EffectInputs) -> Floats:
        """Torque (n, dof, c) per unit of each parameter of the additive term `index`, on every joint."""
        effect = self.terms[index].effect
        assert isinstance(effect, Additive)
        return effect.columns(inputs, self.shapes_by_name(index, x))

    def shapes_by_name(self, index: int, x: Floats) -> Shapes:
        """Shapes by name of the term `index` in the vector `x` (K,): numbers, or (dof,) where joints have their own.

        Joints without the effect get the shapes of its first joint.
        """
        term, values = self.terms[index], self.shape_values(index, x)
        names = [shape.name for shape in term.effect.shapes]
        if not term.effect.local_shapes:
            return dict(zip(names, values.tolist(), strict=True))
        by_instance = values.reshape(term.instances, -1)
        by_joint = np.tile(by_instance[0], (self.rig.dof, 1))
        by_joint[list(term.joints)] = by_instance
        return dict(zip(names, by_joint.T, strict=True))

    def instance_entries(self, index: int) -> Ints:
        """(instances, k) entries of the vector that each instance of the term `index` has of its own."""
        term, entries = self.terms[index], np.arange(len(self.parameters))[self._entries[index]]
        parts = np.split(entries, [term.instances * len(term.local_parameters)])
        return np.concatenate([part.reshape(term.instances, -1) for part in parts[: 1 + term.effect.local_shapes]], 1)

    def mechanism_of(self, rig: Rig) -> RigidMechanism:
        """Return the mechanism for a corrected `rig`; without effects, nothing corrects it."""
        return self.mechanism if rig is self.rig or not self.terms else mechanisms.create(rig)

    def corrections(self, x: Floats, rig: Rig) -> tuple[Rig, tuple[PositionCorrection, ...]]:
        """Return the true one of a `rig`, and what makes true positions of measured ones, one after the other."""
        corrections = []
        for index, _, effect in self.signals:
            values = self.signal_values(index, x)
            rig = effect.rig(rig, values) if effect.rig else rig
            if effect.reading:
                corrections.append(PositionCorrection(effect.reading, values))
        return rig, tuple(corrections)

    def reports(self, x: Floats) -> Iterator[tuple[Term, Report]]:
        """Yield the distortions of the true torque on its way to what is reported, in their order."""
        for index, term, effect in self.signals:
            if effect.report:
                yield term, _report(effect.report, self.signal_values(index, x))

    @cached_property
    def additive(self) -> tuple[tuple[int, Term, Additive], ...]:
        """Index, term and effect of the terms that add torque."""
        return tuple(
            (index, term, term.effect) for index, term in enumerate(self.terms) if isinstance(term.effect, Additive)
        )

    @cached_property
    def signals(self) -> tuple[tuple[int, Term, Signal], ...]:
        """Index, term and effect of the terms that distort a measurement."""
        return tuple(
            (index, term, term.effect) for index, term in enumerate(self.terms) if isinstance(term.effect, Signal)
        )

    def signal_values(self, index: int, x: Floats) -> Values:
        """Parameters and shapes by name with which the signal effect of the term `index` is evaluated."""
        term = self.terms[index]
        values = self.local_values(index, x)
        if not term.effect.whole_robot:
            by_joint = np.zeros((self.rig.dof, values.shape[1]))
            by_joint[list(term.joints)] = values
            values = by_joint
        parameters = {quantity.name: values[:, i] for i, quantity in enumerate(term.local_parameters)}
        shapes = self.shape_values(index, x)
        return {**parameters, **{shape.name: shapes[i : i + 1] for i, shape in enumerate(term.effect.shapes)}}


def _mechanism_entry(parameter: Parameter, *, replaced: bool) -> ParameterEntry:
    """Entry of a parameter of the mechanism; one that is `replaced` by an effect stays at zero."""
    lower, upper = (0.0, 0.0) if replaced else (0.0 if parameter.physically_positive else -np.inf, np.inf)
    return ParameterEntry(
        parameter.name,
        parameter.unit,
        parameter.meaning,
        lower,
        upper,
        term=-1,
        linear=not replaced,
        free=not replaced,
        scale=1.0,
    )


def _report(report: Callable[[Floats, EffectInputs, Values], Floats], values: Values) -> Report:
    return lambda torque, inputs: report(torque, inputs, values)

"""A mechanism with effects, and all their parameters in one vector."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.dynamics.effects.base import Additive, Effect, Quantity, Signal
from ident.dynamics.mechanisms import Mechanism
from recordings.recording import Bools, Floats
from recordings.rig import Rig


@dataclass(frozen=True)
class Term:
    """An effect on some joints."""

    name: str
    effect: Effect
    joints: tuple[int, ...]
    """From 0; all of them for an effect of the whole robot."""

    @property
    def instances(self) -> int:
        """How many sets of its own parameters it has."""
        return 1 if self.effect.whole_robot else len(self.joints)

    @property
    def local_parameters(self) -> tuple[Quantity, ...]:
        """What each owner has: coefficients, in which the torque is linear, or parameters of a signal."""
        if isinstance(self.effect, Additive):
            return self.effect.coefficients
        return self.effect.parameters if isinstance(self.effect, Signal) else ()


@dataclass(frozen=True)
class ParameterEntry:
    """One entry of a composition's parameter vector."""

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    term: int
    """Which of the terms it belongs to; -1: the mechanism."""
    linear: bool
    free: bool
    """False for what is not to be refined, such as a number of something."""
    scale: float
    """A typical size of a searched parameter: the smallest at which a search for it begins; 1 for others."""


@dataclass(frozen=True)
class ModelStructure:
    """A mechanism of `rig` with `terms`."""

    mechanism: Mechanism
    rig: Rig
    terms: tuple[Term, ...] = ()

    def with_term(self, term: Term) -> "ModelStructure":
        """With one more."""
        return replace(self, terms=(*self.terms, term))

    def without_term(self, index: int) -> "ModelStructure":
        """With one less."""
        return replace(self, terms=self.terms[:index] + self.terms[index + 1 :])

    @cached_property
    def parameters(self) -> tuple[ParameterEntry, ...]:
        """The entries of the vector: the mechanism's, then term by term what its owners have in turn, and shapes."""
        own = [
            ParameterEntry(
                one.name, one.unit, one.meaning, 0.0 if one.nonnegative else -np.inf, np.inf, -1, True, True, 1.0
            )
            for one in self.mechanism.parameters
        ]
        return *own, *(entry for index, term in enumerate(self.terms) for entry in self._term_parameters(index, term))

    def _term_parameters(self, index: int, term: Term) -> list[ParameterEntry]:
        linear = isinstance(term.effect, Additive)
        joints = (None,) if term.effect.whole_robot else term.joints
        own = [
            self._parameter(index, term, quantity, joint, linear)
            for joint in joints
            for quantity in term.local_parameters
        ]
        return own + [self._parameter(index, term, quantity, None, False) for quantity in term.effect.shapes]

    def _parameter(
        self, index: int, term: Term, quantity: Quantity, joint: int | None, linear: bool
    ) -> ParameterEntry:
        again = sum(other.name == term.name for other in self.terms[:index])
        name = f"{term.name}{f'#{again + 1}' if again else ''}.{quantity.name}"
        effort, position = self.rig.effort_units[joint or 0], self.rig.position_units[joint or 0]
        return ParameterEntry(
            name if joint is None else f"{name}{joint + 1}",
            quantity.unit.format(effort=effort, position=position),
            quantity.meaning if joint is None else f"{quantity.meaning}, joint {joint + 1}",
            quantity.lower,
            quantity.upper,
            index,
            linear,
            linear or quantity.searched,
            min((abs(start) for start in quantity.initial_guesses if start), default=1.0),
        )

    @cached_property
    def linear(self) -> Bools:
        """(K,) which entries the torque is linear in."""
        return np.array([entry.linear for entry in self.parameters])

    def parameter_mask(self, index: int) -> Bools:
        """(K,) which entries are those of the term `index`; -1: the mechanism."""
        return np.array([entry.term == index for entry in self.parameters])

    def load_parameters(self, x: Floats) -> Floats:
        """(k or k + 1,) by what effects reckon the load: the mechanism's parameters, and the forearms' mass."""
        truths = [x[self.parameter_mask(index)] for index, term in enumerate(self.terms) if term.effect.mandatory]
        return np.concatenate([x[self.parameter_mask(-1)], *truths])

    def local_values(self, index: int, x: Floats) -> Floats:
        """(owners, c) what the owners of the term `index` have, in the vector `x` (K,)."""
        term = self.terms[index]
        values = x[self.parameter_mask(index)]
        return values[: term.instances * len(term.local_parameters)].reshape(
            term.instances, len(term.local_parameters)
        )

    def shape_values(self, index: int, x: Floats) -> Floats:
        """(s,) shapes of the term `index` in the vector `x` (K,)."""
        term = self.terms[index]
        return x[self.parameter_mask(index)][term.instances * len(term.local_parameters) :]

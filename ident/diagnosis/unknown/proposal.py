"""Propose a formula for what no effect of the library explains, and let the judge of effects decide.

The laws of `laws` are screened as effects are, the most promising are fitted with all parameters of the model, and
held-out rows confirm each term. A formula has at most two terms.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Improvement
from ident.diagnosis.judge.judge import judge
from ident.diagnosis.judge.price import is_preferred, score, slack
from ident.diagnosis.search.best_first import joints_that_leave_much
from ident.diagnosis.search.candidates import Candidates, Fits, added_term
from ident.diagnosis.unknown.laws import Law, effect_of, laws
from ident.diagnosis.unknown.residual_dependence import MIN_RELATIVE_SHARE
from ident.diagnosis.unknown.residual_test import UnexplainedResidual
from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.formula import arguments
from ident.dynamics.structure import Term

NAME = "proposed"
"""Of the effect in its model."""
_TERMS = 2
_FITTED = 10
"""Laws that are fitted in each step: screening tries their shapes at a few values only."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A formula that held-out rows confirm."""

    before: FittedModel
    """The model without it."""
    after: FittedModel
    """With it: the last term."""
    laws: tuple[Law, ...]
    alternatives: tuple[str, ...]
    """Other formulas that these data cannot tell from it, the simplest first."""

    @property
    def term(self) -> Term:
        """The formula as an effect on its joints."""
        return self.after.terms[-1]

    @property
    def effect(self) -> Additive:
        """The formula as an effect."""
        assert isinstance(self.term.effect, Additive)
        return self.term.effect

    @property
    def columns(self) -> tuple[str, ...]:
        """The torque per unit of each coefficient as text."""
        return tuple(text for law in self.laws for text in law.texts)

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of the quantities and shapes that it uses."""
        assert self.effect.formula is not None
        return arguments(self.effect.formula)

    @property
    def shapes(self) -> dict[str, float]:
        """Its shapes by name."""
        shapes = self.after.solution.structure.shapes_by_name(len(self.after.terms) - 1, self.after.solution.x)
        return {name: float(value) for name, value in shapes.items()}

    @cached_property
    def improvement(self) -> Improvement:
        """On the held-out rows, by the formula."""
        return self.after.improvement_over(self.before)


def propose(model: FittedModel, unexplained: UnexplainedResidual) -> Proposal | None:
    """A formula for the `unexplained` residual of `model`; None if none is confirmed.

    In place of a curve with knots, a formula is proposed where all rows together get no worse.
    """
    fits, others = Fits(model.split), _others(unexplained, len(model.split.torque_rms))
    joints, proposals = unexplained.joints, []
    if joints:
        proposals.append(_Pursuit(fits, model, joints, others).proposal())
    for index, term in enumerate(model.terms):
        if term.effect.curve:
            bare, both = fits.without_effect(model, index), sorted({*joints, *term.joints})
            proposals.append(_Pursuit(fits, bare, both, others).proposal())
    better = [each for each in proposals if each and score(each.after) < score(model)]
    return min(better, key=lambda each: score(each.after), default=None)


def _others(unexplained: UnexplainedResidual, dof: int) -> list[int]:
    """Joints (from 0) whose motion a formula may use: those that are named, or all where no curve explains enough."""
    dependences = unexplained.dependences
    if len(dependences) < len(unexplained.joints) or any(each.explained < MIN_RELATIVE_SHARE for each in dependences):
        return list(range(dof))
    curves = [curve for each in dependences for curve in each.curves]
    return sorted({curve.variable_joint - 1 for curve in curves if curve.variable_joint != curve.joint})


class _Pursuit:
    """The search of one formula, term by term."""

    def __init__(self, fits: Fits, model: FittedModel, joints: Sequence[int], others: Sequence[int]) -> None:
        self._fits, self._model = fits, model
        split, solution = model.split, model.solution
        inputs = [each.recorded_inputs(solution.structure, solution.x) for each in split.train_predictors]
        self._laws = laws(inputs, joints, others)
        self._candidates = Candidates(fits, {text: effect_of([law], joints) for text, law in self._laws.items()})

    def proposal(self) -> Proposal | None:
        """The formula; None if no law is confirmed."""
        best, chosen, alternatives = self._model, list[str](), list[str]()
        while len(chosen) < _TERMS and joints_that_leave_much(best) and (accepted := self._accepted(best)):
            text, model = min(accepted.items(), key=lambda each: score(each[1]))
            best, alternatives = model, self._alternatives(best, model, accepted)
            chosen.append(text)
        return self._merged(chosen, best, alternatives) if chosen else None

    def _accepted(self, model: FittedModel) -> dict[str, FittedModel]:
        """`model` with each of the laws that promise most and that the judge accepts, by their text."""
        promising = sorted(self._candidates.screen(model).best.values(), key=lambda candidate: candidate.loss)
        extended = {candidate.term.name: self._candidates.add(model, candidate) for candidate in promising[:_FITTED]}
        return {
            text: other
            for text, other in extended.items()
            if score(other) < score(model) and judge(model, other, added_term(model, other)).accepted
        }

    def _alternatives(self, before: FittedModel, model: FittedModel, accepted: dict[str, FittedModel]) -> list[str]:
        """Texts of the other `accepted` laws that the data cannot tell from that of `model`, the simplest first."""
        loss = model.solution.loss
        most = loss + slack(before.solution.loss, loss, model.split.independent_rows)
        equal = {
            text: len(other.solution.x)
            for text, other in accepted.items()
            if other is not model and other.solution.loss <= most and not is_preferred(model, other)
        }
        return sorted(equal, key=lambda text: (equal[text], len(text)))

    def _merged(self, chosen: Sequence[str], best: FittedModel, alternatives: Sequence[str]) -> Proposal | None:
        """The `chosen` laws of the `best` model as one effect; None if the judge does not accept it."""
        structure, x = best.solution.structure, best.solution.x
        indices = [next(i for i, term in enumerate(best.terms) if term.name == text) for text in chosen]
        joints = sorted({joint for index in indices for joint in best.terms[index].joints})
        values = [structure.shapes_by_name(index, x) for index in indices]
        parts = _distinct([self._laws[text].with_values(own) for text, own in zip(chosen, values, strict=True)])
        proposal = self._fitted(parts, joints, alternatives)
        for name, value in proposal.shapes.items():
            if name.startswith("n") and round(value):  # the order of a wave may be a whole number
                whole = [law.renamed(name, f"{value:.0f}") for law in proposal.laws]
                proposal = min(
                    proposal, self._fitted(whole, joints, alternatives), key=lambda each: score(each.after)
                )
        return proposal if judge(self._model, proposal.after, len(self._model.terms)).accepted else None

    def _fitted(self, parts: Sequence[Law], joints: Sequence[int], alternatives: Sequence[str]) -> Proposal:
        """The model with the sum of the laws `parts` on `joints`, all parameters refitted."""
        split, solution = self._model.split, self._model.solution
        structure = solution.structure.with_term(Term(NAME, effect_of(parts, joints), tuple(joints)))
        shapes = [shape.first_guess for law in parts for shape in law.shapes]
        start = solution.x, np.zeros(len(structure.parameters) - len(solution.x) - len(shapes)), shapes
        fitted = FittedModel(split, split.fit(structure, np.concatenate(start)))
        return Proposal(self._model, fitted, tuple(parts), tuple(alternatives))


def _distinct(laws: Sequence[Law]) -> list[Law]:
    """The `laws` with different names for their shapes."""
    taken, distinct = set[str](), list[Law]()
    for law in laws:
        for shape in law.shapes:
            if shape.name in taken:
                law = law.renamed(shape.name, f"{shape.name}_2")
        taken |= {shape.name for shape in law.shapes}
        distinct.append(law)
    return distinct

"""Whether an extension of a model is accepted: significance, support of the test rows, plausibility, simplicity."""

from collections.abc import Sequence

import numpy as np

from ident.diagnosis.judge.confirmation import MIN_DECISIVE_SHARE, is_decisive, is_supported
from ident.diagnosis.judge.steps import FittedModel
from ident.diagnosis.search.candidate_search import MIN_SIGNIFICANCE, CandidateSearch
from ident.diagnosis.search.claims import Claims
from ident.diagnosis.search.joint_subsets import MIN_JOINT_SHARE
from ident.diagnosis.split.split_data import SplitData, rms

EQUIVALENT_SHARE = 0.04
"""Candidates whose reductions differ by less than this share are equivalent."""
MIN_FITTED_SHARE = 0.05
"""While a large excess error remains, an effect must explain this share of that of the training rows."""
MIN_ADDED_SHARE = 0.15
"""An effect is not added if it explains less than this share of a large excess error."""
LARGE_EXCESS = 3.0
"""Mean square above the noise floor that counts as large, in units of the squared floor."""
MAX_ALTERNATIVE_RATIO = 0.5
"""An alternative selection is better if its excess error is below this share of that of the first one."""
MIN_TORQUE_SHARE = 0.002
"""Changes of the residual below this share of the torque are ignored."""


class Acceptance:
    """Decides between a model, its extensions, and simpler ones."""

    def __init__(self, split: SplitData, search: CandidateSearch) -> None:
        self._split, self._search = split, search
        self.claims = Claims(search)
        self.compared: dict[str, int] = {}
        """Number of models among which the test rows chose each effect; the largest where they did so repeatedly."""

    def first_confirmed(self, model: FittedModel, candidates: Sequence[FittedModel]) -> FittedModel | None:
        """The simplest of the best extensions that is confirmed; if it is not, the next ones are tried."""
        candidates = self.claims.plausible(candidates, model)
        count = len(candidates)
        while candidates:
            best = self.simplest(model, candidates)
            chosen = self.accepted(model, best)
            if chosen is not None and not self.is_minor(model, chosen):
                name = chosen.terms[-1].name
                self.compared[name] = max(count, self.compared.get(name, 1))
                return chosen
            candidates = [candidate for candidate in candidates if candidate is not best]
        return None

    def accepted(self, before: FittedModel, model: FittedModel) -> FittedModel | None:
        """`model`, or the simpler one that it does not differ from, if it is confirmed and resolved; else None."""
        simpler = self.claims.simplified(model)
        return simpler if self.is_confirmed(before, simpler) and self.claims.is_resolved(simpler) else None

    def is_confirmed(self, before: FittedModel, after: FittedModel) -> bool:
        """Whether the last effect of `after` improves the model significantly on training rows and test rows."""
        parameters = len(after.solution.x) - len(before.solution.x)
        changed = [b - a for b, a in zip(before.residuals, after.residuals, strict=True)]
        size = rms(changed, [np.isfinite(change) for change in changed])
        return (
            self._search.is_significant(before.solution.loss, after.solution.loss, parameters)
            and bool((size > MIN_TORQUE_SHARE * self._split.torque_rms).any())
            and is_supported(after.improvement_over(before))
        )

    def without_minor_joints(self, model: FittedModel) -> FittedModel:
        """`model` without the effects on joints where they are small beside the others and not confirmed."""
        for index, term in enumerate(model.terms):
            if len(term.joints) == 1 or term.effect.whole_robot or term.effect.mandatory:
                continue
            squares = (model.solution.structure.local_values(index, model.solution.x) ** 2).sum(axis=1)
            for instance in np.flatnonzero(squares < MIN_JOINT_SHARE * squares.max()):
                kept = [other != instance for other in range(len(squares))]
                fewer = self._search.without_instances(model, index, kept)
                if not self.is_confirmed(fewer, model):
                    return self.without_minor_joints(fewer)
        return model

    def is_minor(self, before: FittedModel, after: FittedModel) -> bool:
        """Whether `after` explains a small part of a large excess error, of the test rows or of the training rows.

        Many such small effects together can imitate any effect that is not in the library, and so can a curve. An
        effect that shows on other rows than those that it was fitted to is an extrapolation, unless those decide. One
        that explains most of the training rows is not small, whatever else is missing on the test rows.
        """
        improvement = after.improvement_over(before)
        fitted = after.improvement_over(before, self._split.train)
        extrapolates = fitted.share < MIN_FITTED_SHARE and not is_decisive(improvement)
        small = (improvement.share < MIN_ADDED_SHARE and fitted.share < MIN_DECISIVE_SHARE) or extrapolates
        imitates = after.terms[-1].effect.curve and fitted.remaining > LARGE_EXCESS
        return imitates or (small and improvement.remaining > LARGE_EXCESS)

    def is_promising(self, model: FittedModel, extension: FittedModel) -> bool:
        """Whether test rows support `extension`, or it explains so much that it deserves a second effect."""
        return (
            self.is_confirmed(model, extension)
            or extension.solution.loss < MAX_ALTERNATIVE_RATIO * model.solution.loss
        )

    def is_far_better(self, model: FittedModel, reference: FittedModel) -> bool:
        """Whether `model` leaves far less excess error than the `reference`, beside the same noise floor."""
        return model.improvement_over(reference).share > 1 - MAX_ALTERNATIVE_RATIO

    def may_be_far_better(self, model: FittedModel, reference: FittedModel) -> bool:
        """Whether screening promises that an extension of `model` leaves far less than the `reference`."""
        return self._search.promised_loss(model) < MAX_ALTERNATIVE_RATIO * reference.solution.loss

    def leaves_much(self, model: FittedModel) -> bool:
        """Whether the error of `model` is large beside the noise floor."""
        return self.excess(model) > LARGE_EXCESS

    def excess(self, model: FittedModel) -> float:
        """Mean square of the test residual of `model` above the noise floor, in units of the squared floor."""
        return model.improvement_over(model).remaining

    def simplest(self, model: FittedModel, candidates: Sequence[FittedModel]) -> FittedModel:
        """The simplest extension equivalent to the best, unless the data clearly prefer another of them."""
        equivalent = self.equivalent(model.solution.loss, candidates)
        simplest = min(equivalent, key=lambda candidate: (len(candidate.solution.x), candidate.solution.loss))
        return next((candidate for candidate in equivalent if self.is_preferred(simplest, candidate)), simplest)

    def equivalent(self, loss_before: float, candidates: Sequence[FittedModel]) -> list[FittedModel]:
        """Extensions whose loss exceeds the best one by no more than chance and a small share of the reduction."""
        best = min(candidate.solution.loss for candidate in candidates)
        slack = max(EQUIVALENT_SHARE * (loss_before - best), MIN_SIGNIFICANCE * self._search.chance_reduction(best))
        return [candidate for candidate in candidates if candidate.solution.loss - best <= slack]

    def is_preferred(self, alternative: FittedModel, model: FittedModel) -> bool:
        """Whether the data prefer `model` to an `alternative` that explains nearly as much.

        Either the test rows are decisive, or all rows are, because the discriminating motion may be in the training
        rows. In the latter case the improvement must exceed what extra parameters gain by fitting noise.
        """
        if is_decisive(model.improvement_over(alternative)):
            return True
        parameters = max(len(model.solution.x) - len(alternative.solution.x), 1)
        if not self._search.is_significant(alternative.solution.loss, model.solution.loss, parameters):
            return False
        return is_decisive(model.improvement_over(alternative, self._split.scored))

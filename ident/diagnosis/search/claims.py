"""Which extensions of a model can be claimed: what cannot be true is refused, and what is not needed simplified."""

from collections.abc import Sequence

import numpy as np

from ident.diagnosis.judge.physical_limits import (
    implausibility,
    implausible_shape,
    is_only_large,
    resolved_instances,
    simpler_effect,
    unresolved,
)
from ident.diagnosis.judge.steps import FittedModel
from ident.diagnosis.search.candidate_search import CandidateSearch
from ident.diagnosis.split.split_data import rms

EXTRAORDINARY_RATIO = 5.0
"""An effect larger than hardware usually has is believed only if each plausible one leaves this many times its mean
square on the test rows of its joints."""
_TINY = 1e-12


class Claims:
    """Accepts or refuses the last effect of a model, and keeps the reasons of refusals."""

    def __init__(self, search: CandidateSearch) -> None:
        self._search = search
        self.refused: dict[str, str] = {}
        """Effects that were refused because they cannot be true, with the last reason."""

    def plausible(self, candidates: Sequence[FittedModel], before: FittedModel) -> list[FittedModel]:
        """The `candidates`, extensions of `before`, whose last effect can be true.

        One that is only too large is among them if nothing else comes near: what is extraordinary needs extraordinary
        evidence.
        """
        plausible = [
            candidate
            for candidate in candidates
            if self._is_accepted(candidate.terms[-1].name, implausibility(candidate, before))
        ]
        rivals = [before, *plausible]
        return plausible + [
            candidate
            for candidate in candidates
            if is_only_large(candidate, before)
            and min(_error_ratio(rival, candidate) for rival in rivals) > EXTRAORDINARY_RATIO
        ]

    def is_resolved(self, model: FittedModel) -> bool:
        """Whether the data determine the strength of the last effect of `model`."""
        return self._is_accepted(model.terms[-1].name, unresolved(model))

    def keeps_shape(self, model: FittedModel, index: int) -> bool:
        """Whether the shape of the effect `index` of `model` can still be true, beside the effects that are left."""
        return self._is_accepted(model.terms[index].name, implausible_shape(model, index))

    def simplified(self, model: FittedModel) -> FittedModel:
        """`model`, or one with the simpler effect that its last one does not differ from."""
        name = simpler_effect(model)
        return (self._search.replace_last(model, name) if name else None) or model

    def all_simplified(self, model: FittedModel) -> FittedModel:
        """`model` with the simpler effect in place of each that does not differ from it beside the later ones."""
        for index in range(len(model.terms)):
            if simpler_effect(model, index):
                at_end = self._search.moved_to_end(model, index)
                simpler = self.simplified(at_end)
                return model if simpler is at_end else self.all_simplified(simpler)
        return model

    def without_zero_joints(self, model: FittedModel) -> FittedModel:
        """`model` without the effects on joints where their strength is zero within its interval."""
        for index, term in enumerate(model.terms):
            if len(term.joints) == 1 or term.effect.whole_robot or term.effect.mandatory:
                continue
            kept = resolved_instances(model, index)
            if any(kept) and not all(kept):
                model = self._search.without_instances(model, index, kept)
        return model

    def on_fewest_joints(self, model: FittedModel) -> FittedModel:
        """`model` with effects that only differ between joints on the fewest joints that explain as much."""
        for index, term in enumerate(model.terms):
            other = self._search.on_other_joints(model, index) if term.effect.differential else None
            if other is None:
                continue
            parameters = len(model.solution.x) - len(other.solution.x)
            if not self._search.is_significant(other.solution.loss, model.solution.loss, parameters):
                model = other
        return model

    def _is_accepted(self, name: str, reason: str | None) -> bool:
        if reason:
            self.refused[name] = reason
        return reason is None


def _error_ratio(rival: FittedModel, model: FittedModel) -> float:
    """Mean square of `rival` over that of `model` on test rows, on average over the joints of the last effect.

    The error of other joints is common to both, and training rows may flatter either.
    """
    joints = list(model.terms[-1].joints)
    errors, least = (rms(each.residuals, model.split.test)[joints] for each in (rival, model))
    return float(np.mean((errors / np.maximum(least, _TINY)) ** 2))

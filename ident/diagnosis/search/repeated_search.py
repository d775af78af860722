"""Search the shapes of effects again, beside effects that were missing when they were searched first.

An effect that is fitted while another is missing imitates both: its shapes end in a local minimum, which the fit of
all parameters together does not leave. Backfitting searches each effect on what all the others leave.
"""

from ident.diagnosis.judge.steps import FittedModel
from ident.diagnosis.search.candidate_search import CandidateSearch


def searched_again(search: CandidateSearch, model: FittedModel) -> FittedModel:
    """`model`, with each of its nonlinear effects but the last searched again where that leaves clearly less."""
    for index in range(len(model.terms) - 1):
        if _is_searched(model, index):
            again = _again(search, model, index)
            parameters = max(len(again.solution.x) - len(model.solution.x), 1)
            if search.is_significant(model.solution.loss, again.solution.loss, parameters):
                model = again
    return model


def has_shapes(model: FittedModel) -> bool:
    """Whether an effect of `model` has shapes that are searched."""
    return any(_is_searched(model, index) for index in range(len(model.terms)))


def _is_searched(model: FittedModel, index: int) -> bool:
    """Whether the torque is not linear in the parameters of the effect `index`."""
    structure, effect = model.solution.structure, model.terms[index].effect
    nonlinear = structure.parameter_mask(index) & ~structure.linear
    return bool(nonlinear.any()) and not (effect.mandatory or effect.repeated)


def _again(search: CandidateSearch, model: FittedModel, index: int) -> FittedModel:
    """`model` with the effect `index` as a search beside all the others finds it; `model` if that finds nothing."""
    reduced = search.without_effect(model, index)
    candidate = search.candidate(reduced, model.terms[index].name)
    if candidate is None or candidate.loss >= model.solution.loss:
        return model
    again = search.add(reduced, candidate)
    for _ in model.terms[index + 1 :]:  # these stand behind it, as before
        again = search.moved_to_end(again, index)
    return again

"""What the last model of a selection leaves, and whether its effects only imitate something unknown."""

from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.unknown.imitation import remove_imitations
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit, fit_curves
from ident.diagnosis.unknown.unexplained_residual import UnexplainedResidual, estimate_unexplained


def analyse_unexplained(
    search: Search, selection: Selection, forced: bool
) -> tuple[Selection, UnexplainedResidual, NonparametricFit | None]:
    """The selection without imitations, its unexplained residual, and curves in place of what is unknown.

    forced: whether the user chose the effects, which then stay.
    """
    unexplained, learned = estimate_unexplained(selection.model), None
    if not unexplained.significant:
        return selection, unexplained, None
    if not forced:
        selection, learned = remove_imitations(search, selection)
    learned = learned or fit_curves(selection.model)
    dependences = learned.described if learned and learned.supported else None
    return selection, estimate_unexplained(selection.model, dependences), learned

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
    model = selection.model.on_judged_rows
    unexplained = estimate_unexplained(model)
    if not unexplained.significant:
        return selection, unexplained, None
    learned = fit_curves(model, unexplained.dependences) if unexplained.dependences else None
    if forced:
        return selection, unexplained, learned
    exchanged, learned = remove_imitations(search, selection, learned)
    return (
        exchanged,
        unexplained if exchanged is selection else estimate_unexplained(exchanged.model.on_judged_rows),
        learned,
    )

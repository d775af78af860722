"""Check whether something unknown explains the data better than the effects that imitate it.

An unknown effect of another joint's motion, or of time, is approximated by several known effects together. Curves
over these variables may take their place, at their price. Curves over the joint's own motion may not: load,
pre-sliding and low speed are functions of it, so that a curve approximates every effect that depends on them.
"""

from collections.abc import Sequence

from ident.diagnosis.judge.improvement import MIN_SHARE
from ident.diagnosis.judge.price import score
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit, fit_curves
from ident.diagnosis.unknown.residual_dependence import ResidualDependence
from ident.diagnosis.unknown.unexplained_residual import estimate_unexplained


def remove_imitations(
    search: Search, selection: Selection, learned: NonparametricFit | None
) -> tuple[Selection, NonparametricFit | None]:
    """Truncate the `selection` before the effects in whose place curves explain more.

    learned: curves beside all effects, if there are any; returned are those beside the effects that are left.
    """
    final = selection.model
    # A given model has effects from the start; they stay.
    mandatory = [all(term.effect.mandatory for term in step.model.terms) for step in selection.steps]
    exchanges = {}
    for number in range(max(i for i, only in enumerate(mandatory) if only or not i), len(mandatory) - 1):
        model = selection.steps[number].model.on_judged_rows
        dependences = estimate_unexplained(model).dependences
        if _beyond_own_motion(dependences):
            exchanges[number] = fit_curves(model, dependences)
    fits = [*exchanges.values(), *([learned] if learned else [])]
    for number, fit in exchanges.items():
        improvement = fit.model.improvement_over(final)
        accepted = improvement.is_supported and score(fit.model) < score(final)
        further = max(other.model.improvement_over(fit.model).reduction for other in fits)
        if accepted and further < MIN_SHARE * improvement.reduction:  # the names take but a trifle beside the curves
            variables = dict.fromkeys(name for dependence in fit.dependences for name in dependence.variables)
            reason = f"curves over {', '.join(variables)} explain more in its place"
            return search.truncated(selection, number, reason), fit
    return selection, learned


def _beyond_own_motion(dependences: Sequence[ResidualDependence]) -> bool:
    """Whether one is over what no effect of the joint itself depends on: another joint's motion, or time."""
    curves = [curve for dependence in dependences for curve in dependence.curves]
    return any(curve.variable_joint != curve.joint or curve.variable == "time" for curve in curves)

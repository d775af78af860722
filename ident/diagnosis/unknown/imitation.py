"""Check whether something unknown explains the data better than the effects that imitate it.

An unknown effect of another joint's motion, or of time, is approximated by several known effects together. Curves
over these variables may take their place, where held-out rows say so. Curves over the joint's own motion may not:
load, pre-sliding and low speed are functions of it, so that a curve approximates every effect that depends on them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Blocks, Improvement
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit, fit_curves, fit_curves_over
from ident.diagnosis.unknown.residual_dependence import ResidualDependence
from recordings.recording import Bools

NEGLIGIBLE_SHARE = 0.02
"""Effects are replaced by curves if they improve on these by less than this share of what the curves explain."""


def remove_imitations(search: Search, selection: Selection) -> tuple[Selection, NonparametricFit | None]:
    """Truncate the `selection` before the effects that curves replace with an improvement.

    Returns the selection, and the curves if they replaced anything.
    """
    final = selection.model
    steps = enumerate(selection.steps)
    # A given model has effects from the start; they stay.
    first = max((i for i, step in steps if all(term.effect.mandatory for term in step.model.terms)), default=0)
    if first == len(selection.steps) - 1:
        return selection, None
    fits = list(_with_curves(search, selection, first))
    rows = _judged_by_all(final, [fit for _, fit in fits])

    def improvement(before: FittedModel, after: FittedModel) -> Improvement:
        return Blocks.of(final.split, before.residuals, after.residuals, final.noise_floor.rms, rows).improvement()

    models = [fit.model for _, fit in fits]
    *excesses, remaining = (improvement(model, model).remaining for model in (*models, final))
    least = min(excesses, default=remaining)
    for (number, fit), excess in zip(fits, excesses, strict=True):
        negligible = excess - least <= NEGLIGIBLE_SHARE * (remaining - least)
        needed = improvement(fit.model, models[excesses.index(least)]).is_supported and not negligible
        if number < len(selection.steps) - 1 and improvement(final, fit.model).is_supported and not needed:
            return search.truncated(selection, number, _reason(fit)), fit
    return selection, None


def _reason(fit: NonparametricFit) -> str:
    variables = dict.fromkeys(name for dependence in fit.dependences for name in dependence.variables)
    return f"curves over {', '.join(variables)} explain more in its place"


def _with_curves(search: Search, selection: Selection, first: int) -> Iterator[tuple[int, NonparametricFit]]:
    """The model of each step from number `first` on, with curves: pairs of the number and the fit.

    The curves of a step are over what its residual depends on. Once more, they are over what that of the last step
    does, because variables are hardly recognized while much is missing; and over the same variable of the joint
    itself, because an imitation may have explained that part.
    """
    numbers = range(first, len(selection.steps))
    models = [search.with_mandatory(selection.steps[number].model) for number in numbers]
    beside_all = fit_curves(models[-1])
    for number, model in zip(numbers, models, strict=True):
        is_last = number == numbers[-1]
        fit = beside_all if is_last else fit_curves(model)
        if fit and (is_last or _is_of_others(fit.dependences)):
            yield number, fit
        if beside_all and not is_last and _is_of_others(beside_all.dependences):
            fit = fit_curves_over(model, [_with_joint_itself(each) for each in beside_all.dependences])
            yield number, fit.with_explained_of(model)


def _is_of_others(dependences: Sequence[ResidualDependence]) -> bool:
    """Whether curves are over what no effect of the joint itself depends on: another joint's motion, or time."""
    inputs = [(each.joint, curve) for each in dependences for curve in each.inputs]
    return any(curve.joint != joint or curve.variable == "time" for joint, curve in inputs)


def _with_joint_itself(dependence: ResidualDependence) -> ResidualDependence:
    """The `dependence`, with the same variable of the joint itself if it is over those of other joints only."""
    if any(curve_input.joint == dependence.joint for curve_input in dependence.inputs):
        return dependence
    itself = replace(dependence.inputs[0], joint=dependence.joint)
    return replace(dependence, inputs=(itself, *dependence.inputs))


def _judged_by_all(final: FittedModel, fits: Sequence[NonparametricFit]) -> list[Bools]:
    """(m, dof) test rows of each recording that the `final` model and all `fits` can judge.

    A curve says nothing beyond its knots, where an effect of the library extrapolates.
    """
    inside = [fit.within_knots() for fit in fits]
    return [
        test
        & np.all([np.isfinite(model.residuals[i]) for model in (final, *(fit.model for fit in fits))], axis=0)
        & np.all([rows[i] for rows in inside], axis=0)[..., None]
        for i, test in enumerate(final.split.test)
    ]

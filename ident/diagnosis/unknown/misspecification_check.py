"""Check whether one unknown effect explains the data better than the effects that were selected.

An unknown effect is often approximated by several known effects together. If learned curves in place of them leave
less on the test rows, or if the motion hardly distinguishes them, these effects are removed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.confirmation import is_supported
from ident.diagnosis.judge.improvement import Improvement, measure_improvement
from ident.diagnosis.judge.indistinguishable import indistinguishable
from ident.diagnosis.judge.steps import FittedModel, Selection
from ident.diagnosis.search.stepwise_selection import Selector
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit, fit_curves, fit_curves_over
from ident.diagnosis.unknown.residual_dependence import ResidualDependence
from recordings.recording import Bools

NEGLIGIBLE_SHARE = 0.02
"""Effects are replaced by curves if they improve on these by less than this share of what the curves explain."""


def remove_imitations(selector: Selector, selection: Selection) -> tuple[Selection, NonparametricFit | None]:
    """Truncate the `selection` before the effects that learned curves replace with an improvement.

    Returns the selection, and the curves if they replaced anything.
    """
    final = selection.model
    steps = enumerate(selection.steps)
    # A given model has effects from the start; they stay.
    first = max((i for i, step in steps if all(term.effect.mandatory for term in step.model.terms)), default=0)
    if first == len(selection.steps) - 1:
        return selection, None
    fits = list(_with_curves(selector, selection, first))
    rows = _judged_by_all(final, [fit for _, fit in fits])

    def improvement(before: FittedModel, after: FittedModel) -> Improvement:
        return measure_improvement(final.split, before.residuals, after.residuals, final.noise_floor.rms, rows)

    models = [fit.model for _, fit in fits]
    *excesses, remaining = (improvement(model, model).remaining for model in (*models, final))
    least = min(excesses, default=remaining)
    for (number, fit), excess in zip(fits, excesses, strict=True):
        negligible = excess - least <= NEGLIGIBLE_SHARE * (remaining - least)
        needed = is_supported(improvement(fit.model, models[excesses.index(least)])) and not negligible
        if number < len(selection.steps) - 1 and is_supported(improvement(final, fit.model)) and not needed:
            return selector.truncated(selection, number), fit
    return selection, None


def remove_pieces(selector: Selector, selection: Selection) -> Selection:
    """Truncate the `selection` before two effects that are known only together, with the reason as a refusal.

    Each of them was needed beside the other, and yet the motion hardly distinguishes them: only their sum is known,
    and an unknown effect is as good an explanation of it as these two.
    """
    model, initial = selection.model, selection.steps[0].model.names
    parameters, reasons = model.solution.structure.parameters, {}
    for i, j, correlation in indistinguishable(model):
        first, second = (model.terms[parameters[entry].term].name for entry in (i, j))
        if first != second and not {first, second} & initial and _may_be_pieces(model, i, j):
            for name, other in ((first, second), (second, first)):
                reasons[name] = f"only together with {other}, from which this motion hardly distinguishes it: " + (
                    f"their errors correlate by {correlation:+.2f}, so both may be pieces of one unknown effect"
                )
    if not reasons:
        return selection
    number = next(i for i, step in enumerate(selection.steps) if reasons.keys() & {t.name for t in step.model.terms})
    result = selector.truncated(selection, number - 1)
    return replace(result, refused={**result.refused, **reasons})


def _may_be_pieces(model: FittedModel, i: int, j: int) -> bool:
    """Whether something unknown could be put together of the effects with the coefficients `i` and `j`.

    With torques of a given shape that are nearly the same, that takes a small difference of two large ones. Two that
    add up are no pieces.
    """
    parameters = model.solution.structure.parameters
    if any(model.terms[parameters[entry].term].shapes for entry in (i, j)):
        return True
    first, second = (model.solution.rows()[0][:, [i, j]] * model.solution.x[[i, j]]).T
    both = (first != 0) & (second != 0)
    larger = max(np.linalg.norm(first[both]), np.linalg.norm(second[both]))
    return bool(np.linalg.norm(first[both] + second[both]) <= larger)


def _with_curves(selector: Selector, selection: Selection, first: int) -> Iterator[tuple[int, NonparametricFit]]:
    """The model of each step from number `first` on, with curves: pairs of the number and the fit.

    The curves of a step are over what its residual depends on. Once more, they are over what that of the last step
    does, because variables are hardly recognized while much is missing; and over the same variable of the joint
    itself, because an imitation may have explained that part. Steps with effects that the selection has taken away
    again are left out.
    """
    kept = selection.model.names
    numbers = [i for i in range(first, len(selection.steps)) if selection.steps[i].model.names <= kept]
    models = [selector.with_mandatory_effects(selection.steps[number].model, []) for number in numbers]
    beside_all = fit_curves(models[-1])
    for number, model in zip(numbers, models, strict=True):
        is_last = number == numbers[-1]
        fit = beside_all if is_last else fit_curves(model)
        if fit:
            yield number, fit
        if beside_all and not is_last:
            fit = fit_curves_over(model, [_with_joint_itself(each) for each in beside_all.dependences])
            yield number, fit.with_explained_of(model)


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

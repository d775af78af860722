"""Check whether one unknown effect explains the data better than the effects that were selected.

An unknown effect is often approximated by several known effects together. If learned curves in place of them leave
less on the test rows, these effects are removed.
"""

from ident.diagnosis.confirmation import is_supported
from ident.diagnosis.improvement import measure_improvement
from ident.diagnosis.nonparametric_fit import fit_curves
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import FittedModel, Selection
from ident.diagnosis.stepwise_selection import Selector


def remove_imitations(split: SplitData, selector: Selector, selection: Selection) -> Selection:
    """Truncate the `selection` before the effects that learned curves replace with an improvement."""
    final = selection.steps[-1].model
    first = max(
        i for i, step in enumerate(selection.steps) if all(term.effect.mandatory for term in step.model.terms)
    )
    if first == len(selection.steps) - 1:
        return selection
    with_curves = [_fit_with_curves(split, step.model) for step in selection.steps[first:]]
    best = min(with_curves, key=lambda model: _test_loss(split, model, selection))
    for number, model in enumerate(with_curves[:-1], start=first):
        if _is_better(split, final, model, selection) and not _is_better(split, model, best, selection):
            return selector.truncated(selection, number)
    return selection


def _fit_with_curves(split: SplitData, model: FittedModel) -> FittedModel:
    learned = fit_curves(split, model)
    return learned.model if learned else model


def _test_loss(split: SplitData, model: FittedModel, selection: Selection) -> float:
    zeros = [data.torque * 0.0 for data in split.recordings]
    return -measure_improvement(split, zeros, model.residuals, selection.noise_floor.rms).reduction


def _is_better(split: SplitData, before: FittedModel, after: FittedModel, selection: Selection) -> bool:
    return is_supported(measure_improvement(split, before.residuals, after.residuals, selection.noise_floor.rms))

"""Check whether one unknown effect explains the data better than the effects that were selected.

An unknown effect is often approximated by several known effects together. If learned curves in place of them leave
less on the test rows, these effects are removed.
"""

from ident.diagnosis.improvement import measure_improvement
from ident.diagnosis.nonparametric_fit import fit_curves
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Selection, FittedModel
from ident.diagnosis.stepwise_selection import Selector, is_supported


def remove_imitations(material: SplitData, climber: Selector, ladder: Selection) -> Selection:
    """Truncate the `selection` before the effects that learned curves replace with an improvement."""
    top = ladder.steps[-1].model
    first = max(i for i, rung in enumerate(ladder.steps) if all(one.effect.always_true for one in rung.model.terms))
    if first == len(ladder.steps) - 1:
        return ladder
    with_curves = [_fit_with_curves(material, rung.model) for rung in ladder.steps[first:]]
    best = min(with_curves, key=lambda state: _test_loss(material, state, ladder))
    for number, state in enumerate(with_curves[:-1], start=first):
        if _is_better(material, top, state, ladder) and not _is_better(material, state, best, ladder):
            return climber.truncated(ladder, number)
    return ladder


def _fit_with_curves(material: SplitData, state: FittedModel) -> FittedModel:
    learned = fit_curves(material, state)
    return learned.model if learned else state


def _test_loss(material: SplitData, state: FittedModel, ladder: Selection) -> float:
    nothing = [data.torque * 0.0 for data in material.datasets]
    return -measure_improvement(material, nothing, state.residuals, ladder.noise_floor.rms).reduction


def _is_better(material: SplitData, before: FittedModel, after: FittedModel, ladder: Selection) -> bool:
    return is_supported(measure_improvement(material, before.residuals, after.residuals, ladder.noise_floor.rms))

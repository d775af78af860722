"""Whether one thing that nobody knows explains more than the effects that were added for want of a better one.

Something unknown is often imitated, more or less, by several known effects together. Then a curve in place of all of
them leaves less on rows that no fit has seen, and none of them belongs in the model.
"""

from ident.diagnosis.improvement import measure_improvement
from ident.diagnosis.nonparametric_fit import fit_curves
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Selection, FittedModel
from ident.diagnosis.stepwise_selection import Selector, is_supported


def remove_imitations(material: SplitData, climber: Selector, ladder: Selection) -> Selection:
    """The `ladder`, or as much of its beginning as a learned curve does not do better without."""
    top = ladder.steps[-1].model
    first = max(i for i, rung in enumerate(ladder.steps) if all(one.effect.always_true for one in rung.model.terms))
    if first == len(ladder.steps) - 1:
        return ladder
    with_curves = [_with_curve(material, rung.model) for rung in ladder.steps[first:]]
    best = min(with_curves, key=lambda state: _held_out(material, state, ladder))
    for number, state in enumerate(with_curves[:-1], start=first):
        if _better(material, top, state, ladder) and not _better(material, state, best, ladder):
            return climber.truncated(ladder, number)
    return ladder


def _with_curve(material: SplitData, state: FittedModel) -> FittedModel:
    learned = fit_curves(material, state)
    return learned.model if learned else state


def _held_out(material: SplitData, state: FittedModel, ladder: Selection) -> float:
    nothing = [data.torque * 0.0 for data in material.datasets]
    return -measure_improvement(material, nothing, state.residuals, ladder.noise_floor.rms).reduction


def _better(material: SplitData, before: FittedModel, after: FittedModel, ladder: Selection) -> bool:
    return is_supported(measure_improvement(material, before.residuals, after.residuals, ladder.noise_floor.rms))

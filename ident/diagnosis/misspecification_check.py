"""Check whether one unknown effect explains the data better than the effects that were selected.

An unknown effect is often approximated by several known effects together. If learned curves in place of them leave
less on the test rows, these effects are removed.
"""

from collections.abc import Sequence

import numpy as np

from ident.diagnosis.confirmation import is_supported
from ident.diagnosis.improvement import Improvement, measure_improvement
from ident.diagnosis.nonparametric_fit import fit_curves
from ident.diagnosis.steps import FittedModel, Selection
from ident.diagnosis.stepwise_selection import Selector
from recordings.recording import Bools

NEGLIGIBLE_SHARE = 0.02
"""Effects are replaced by curves if they improve on these by less than this share of what the curves explain."""


def remove_imitations(selector: Selector, selection: Selection) -> Selection:
    """Truncate the `selection` before the effects that learned curves replace with an improvement."""
    final = selection.model

    def improvement(before: FittedModel, after: FittedModel, rows: Sequence[Bools] | None = None) -> Improvement:
        return measure_improvement(final.split, before.residuals, after.residuals, final.noise_floor.rms, rows)

    steps = enumerate(selection.steps)
    # A given model has effects from the start; they stay.
    first = max((i for i, step in steps if all(term.effect.mandatory for term in step.model.terms)), default=0)
    if first == len(selection.steps) - 1:
        return selection
    with_curves = [
        _fit_with_curves(selector.with_mandatory_effects(step.model, [])) for step in selection.steps[first:]
    ]
    # Rows that all models can judge.
    arrays = zip(final.split.test, *(model.residuals for model in with_curves), strict=True)
    common = [test & np.isfinite(residuals).all(axis=0) for test, *residuals in arrays]
    best = min(with_curves, key=lambda model: improvement(model, model, common).remaining)
    remaining, least = (improvement(model, model, common).remaining for model in (final, best))
    for number, model in enumerate(with_curves[:-1], start=first):
        needed = is_supported(improvement(model, best)) and (
            improvement(model, model, common).remaining - least > NEGLIGIBLE_SHARE * (remaining - least)
        )
        if is_supported(improvement(final, model)) and not needed:
            return selector.truncated(selection, number)
    return selection


def _fit_with_curves(model: FittedModel) -> FittedModel:
    learned = fit_curves(model)
    return learned.model if learned else model

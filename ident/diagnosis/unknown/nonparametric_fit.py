"""Fit learned curves to an unexplained residual: their values at the knots are coefficients of the model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Improvement
from ident.diagnosis.unknown.residual_dependence import ResidualDependence
from ident.dynamics.effects.learned_curve import LearnedCurve, unknown_curve
from ident.dynamics.structure import Term


@dataclass(frozen=True, eq=False)
class NonparametricFit:
    """Learned curves and the improvement by them."""

    dependences: tuple[ResidualDependence, ...]
    """What the curves are over."""
    model: FittedModel
    """The model with the curves in addition: its last terms."""
    improvement: Improvement
    """On test rows."""

    @property
    def supported(self) -> bool:
        """Whether the test rows support the curves."""
        return self.improvement.is_supported

    @cached_property
    def curves(self) -> tuple[LearnedCurve, ...]:
        """The curves with their values."""
        curves = [curve for dependence in self.dependences for curve in dependence.curves]
        count = sum(len(curve.knots) for curve in curves)
        values = np.split(self.model.solution.x[-count:], np.cumsum([len(curve.knots) for curve in curves])[:-1])
        return tuple(replace(curve, values=tuple(each.tolist())) for curve, each in zip(curves, values, strict=True))


def fit_curves(final: FittedModel, dependences: Sequence[ResidualDependence]) -> NonparametricFit:
    """Fit the curves of the `dependences` together with all parameters of the model `final`."""
    structure = final.solution.structure
    for dependence in dependences:
        for curve in dependence.curves:
            structure = structure.with_term(Term("learned_curve", unknown_curve(curve), (dependence.joint,)))
    start = np.zeros(len(structure.parameters))
    start[: len(final.solution.x)] = final.solution.x
    model = FittedModel(final.split, final.split.fit(structure, start))
    return NonparametricFit(tuple(dependences), model, model.improvement_over(final))

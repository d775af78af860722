"""A fitted model and the rows that judge it."""

import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from tests.ident import building


def test_effects_of_a_fitted_model_are_those_of_its_structure() -> None:
    data = building.split([building.record(2)])
    model = building.fitted(data, "torque_offset", joints=(1,))
    assert isinstance(model, FittedModel)
    assert [(term.name, term.joints) for term in model.terms] == [("torque_offset", (1,))]
    assert building.fitted(data).terms == ()


def test_rows_outside_of_the_travel_of_a_curve_are_not_compared() -> None:
    recordings = [building.record(noise=0.05, seed=i, shape=3, size=1 + i, name=f"motion {i}") for i in range(2)]
    data = building.split(recordings[:1], recordings[1:])
    base, curve = (building.fitted(data, *names) for names in ((), ("position_dependent_friction",)))
    assert not any(rows.any() for rows in base.extrapolated)
    train, held_out = curve.extrapolated
    assert not (train & data.train[0]).any()
    assert (held_out & data.test[1]).any()
    known = data.without_extrapolated_rows(curve.extrapolated)
    assert curve.improvement_over(base) == curve.improvement_over(base, known.test)
    inside = known.test[1]
    assert not (inside & held_out).any()
    assert known.extrapolated_shares == pytest.approx([1 - inside.sum() / data.test[1].sum()])
    assert known.weights is data.weights

"""A fitted model and the rows that judge it."""

import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.motion import Motion
from recordings.recording import Floats
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
    floor = curve.noise_floor.rms
    assert data.judged(base.solution, floor) is data
    train, held_out = data.unjudged(curve.solution, floor)
    assert not (train & data.train[0]).any()
    assert (held_out & data.test[1]).any()
    known = data.judged(curve.solution, floor)
    assert curve.improvement_over(base) == curve.improvement_over(base, known.test)
    inside = known.test[1]
    assert not (inside & held_out).any()
    assert known.unjudged_shares == pytest.approx([1 - inside.sum() / data.test[1].sum()])
    assert known.weights is data.weights


@pytest.mark.parametrize("improves", [True, False])
def test_rows_are_held_out_in_turn_only_where_both_halves_improve(improves: bool) -> None:
    def offset(motion: Motion) -> Floats:
        return 0.3 + 0 * motion.position

    train = building.record(noise=0.05, seed=0, extra=offset, name="train")
    held_out = building.record(noise=0.05, seed=1, extra=offset if improves else None, name="held out")
    data = building.split([train], [held_out])
    model, base = building.fitted(data, "torque_offset"), building.fitted(data)
    in_turn = model.improvement_in_turn(base)
    assert (in_turn is not None) is improves
    assert not in_turn or in_turn.t > model.improvement_over(base).t

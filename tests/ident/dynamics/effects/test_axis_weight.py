"""Weight that the rig file does not declare."""

import pytest

from ident.dynamics.effects.library import load
from recordings.rig import Axis, Rig


def test_only_a_revolute_axis_without_declared_weight_can_have_it() -> None:
    axes = (Axis(), Axis(gravity=True), Axis(type="prismatic"), Axis())
    assert load("axis_weight").possible_joints(Rig(name="bench", mechanism="axes", axes=axes)) == (0, 3)


@pytest.mark.parametrize(("axis", "reason"), [(Axis(gravity=True), "rig file"), (Axis(type="prismatic"), "offset")])
def test_the_reason_is_given_where_no_axis_can_have_it(axis: Axis, reason: str) -> None:
    rig = Rig(name="bench", mechanism="axes", axes=(axis,))
    assert reason in str(load("axis_weight").why_unobservable(rig, True, False))

"""Weight that the rig file does not declare."""

import numpy as np
import pytest

from ident.dynamics.effects.library import load
from recordings.rig import Axis, Rig
from tests.ident import building

SEEDS = [pytest.param(seed, marks=[pytest.mark.slow] if seed > 1 else []) for seed in range(20)]


def hanging(seed: int, **motion: float) -> building.Torque:
    phase = np.random.default_rng(seed).uniform(0.0, 2 * np.pi)
    return building.of_size(lambda motion: np.sin(motion.position + phase), 0.03, **motion)


@pytest.mark.parametrize("seed", SEEDS)
def test_is_named_where_a_weight_is_not_declared(seed: int) -> None:
    train, validate = (
        building.record(noise=0.05, seed=2 * seed + i, shape=shape, extra=hanging(seed, shape=seed), name=f"{i}")
        for i, shape in enumerate((seed, seed + 1000))
    )
    assert building.named(train, validate)[0][0] == "axis_weight"


def test_a_spring_may_be_a_weight_where_the_travel_is_short() -> None:
    spring = building.of_size(lambda motion: motion.position - 0.3, 0.03, size=0.15)
    train, validate = (
        building.record(noise=0.03, seed=shape, shape=shape, extra=spring, size=0.15, name=f"{shape}")
        for shape in (0, 1000)
    )
    assert set(building.named(train, validate)[0]) == {"joint_spring", "axis_weight"}


def test_only_a_revolute_axis_without_declared_weight_can_have_it() -> None:
    axes = (Axis(), Axis(gravity=True), Axis(type="prismatic"), Axis())
    assert load("axis_weight").possible_joints(Rig(name="bench", mechanism="axes", axes=axes)) == (0, 3)


@pytest.mark.parametrize(("axis", "reason"), [(Axis(gravity=True), "rig file"), (Axis(type="prismatic"), "offset")])
def test_the_reason_is_given_where_no_axis_can_have_it(axis: Axis, reason: str) -> None:
    rig = Rig(name="bench", mechanism="axes", axes=(axis,))
    assert reason in str(load("axis_weight").why_unobservable(rig, True, False))

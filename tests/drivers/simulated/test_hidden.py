import json

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import build, library, out_of_library
from drivers.simulated.hidden import draw, draw_effect
from drivers.simulated.seal import truth
from drivers.simulated.sizing import EffectSizer
from recordings.errors import BadInput
from recordings.rig import simulated_rig

RIG = simulated_rig()


@pytest.fixture(scope="module")
def sizer() -> EffectSizer:
    return EffectSizer(RIG, SimConfig())


def test_every_effect_of_the_library_is_drawn_with_valid_parameters() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_effect(rng) for _ in range(300)]
    assert {effect.name() for effect in drawn} == set(library())
    assert {effect.joints for effect in drawn} == {(1,), (2,), (3,), (1, 2), (1, 3), (2, 3), (1, 2, 3)}
    assert all(build(effect.spec()) == effect for effect in drawn)


@pytest.mark.slow
def test_draw_is_reproducible_with_a_size_within_bounds() -> None:
    first, second = (draw(7, RIG, SimConfig()) for _ in range(2))
    assert first == second
    (effect,) = truth(RIG, SimConfig(effects=first), seed=7)["effects"]
    assert 0.0045 <= effect["size"] <= 0.102
    assert effect["name"] == first[0].name


def test_effects_out_of_the_library_are_drawn_by_name() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_effect(rng, out_of_library()) for _ in range(100)]
    assert {effect.name() for effect in drawn} == set(out_of_library())
    assert all(build(effect.spec()) == effect for effect in drawn)


def test_joints_can_be_given() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_effect(rng, ("cogging", "base_tilt"), joints=(3,)) for _ in range(20)]
    assert {(effect.name(), effect.joints) for effect in drawn} == {("cogging", (3,)), ("base_tilt", (1, 2, 3))}


def test_no_effect_is_drawn_for_no_size() -> None:
    assert draw(1, RIG, SimConfig(), sizes=()) == ()


@pytest.mark.slow
def test_two_effects_have_the_requested_sizes(sizer: EffectSizer) -> None:
    names, sizes = ("torque_offset", "joint_spring"), (0.02, 0.05)
    drawn = draw(3, RIG, SimConfig(), names=names, sizes=sizes, joints=(1,), sizer=sizer)
    assert {effect.name for effect in drawn} == set(names)
    assert [effect.joints for effect in drawn] == [(1,), (1,)]
    described = truth(RIG, SimConfig(effects=drawn), seed=3, sizer=sizer)["effects"]
    assert [effect["size"] for effect in described] == pytest.approx(sizes, rel=0.02)


@pytest.mark.parametrize(
    ("names", "size", "complaint"),
    [
        (("cogging",), 0.01, "at least 2 effects.*1 found"),
        (("cogging", "coging"), 0.01, "'coging' found"),
    ],
)
def test_too_few_or_unknown_names_are_explained(
    sizer: EffectSizer, names: tuple[str, ...], size: float, complaint: str
) -> None:
    with pytest.raises(BadInput, match=complaint):
        draw(1, RIG, SimConfig(), names=names, sizes=(size, size), sizer=sizer)


def test_truth_contains_effect_and_plant(sizer: EffectSizer) -> None:
    config = SimConfig(effects=(EffectSpec(name="torque_offset", joints=(3,), parameters={"a": 0.5}),))
    content = truth(RIG, config, seed=None, sizer=sizer)
    (effect,) = content["effects"]
    assert effect["name"] == "torque_offset"
    assert effect["joints"] == [3]
    assert effect["in_library"] is True
    assert effect["depends_on"] == []
    assert effect["parameters"] == {"a": 0.5}
    assert 0.02 < effect["size"] < 0.04
    assert content["plant"]["links"]["platform_mass"] == 2.033
    assert json.loads(json.dumps(content)) == content


def test_truth_marks_effects_out_of_the_library(sizer: EffectSizer) -> None:
    effects = (EffectSpec(name="hose_drag", joints=(1, 3)),)
    (effect,) = truth(RIG, SimConfig(effects=effects), seed=None, sizer=sizer)["effects"]
    assert effect["in_library"] is False
    assert effect["depends_on"] == ["velocity", "joint_1", "joint_3"]


def test_truth_without_effects() -> None:
    assert truth(RIG, SimConfig(), seed=None)["effects"] == []

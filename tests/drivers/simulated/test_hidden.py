import json

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import build, discover
from drivers.simulated.hidden import draw, draw_effect
from drivers.simulated.seal import truth
from recordings.rig import simulated_rig

RIG = simulated_rig()


def test_every_effect_is_drawn_with_valid_parameters() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_effect(rng) for _ in range(200)]
    assert {effect.name() for effect in drawn} == set(discover())
    assert {effect.joints for effect in drawn} == {(1,), (2,), (3,), (1, 2), (1, 3), (2, 3), (1, 2, 3)}
    assert all(build(effect.spec()) == effect for effect in drawn)


@pytest.mark.slow
def test_draw_is_repeatable_and_sized_as_promised() -> None:
    first, second = (draw(7, RIG, SimConfig()) for _ in range(2))
    assert first == second
    (effect,) = truth(RIG, SimConfig(effects=first), seed=7)["effects"]
    assert 0.0045 <= effect["size"] <= 0.102
    assert effect["name"] == first[0].name


def test_truth_says_everything() -> None:
    config = SimConfig(effects=(EffectSpec(name="torque_offset", joints=(3,), parameters={"a": 0.5}),))
    content = truth(RIG, config, seed=None)
    (effect,) = content["effects"]
    assert effect["name"] == "torque_offset"
    assert effect["joints"] == [3]
    assert effect["parameters"] == {"a": 0.5}
    assert 0.02 < effect["size"] < 0.04
    assert content["plant"]["links"]["platform_mass"] == 2.033
    assert json.loads(json.dumps(content)) == content


def test_truth_of_the_bare_machine_has_no_effects() -> None:
    assert truth(RIG, SimConfig(), seed=None)["effects"] == []

import numpy as np
import pytest

from drivers.simulated.config import SimConfig
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


def test_every_effect_is_drawn_with_valid_parameters_on_any_joints_or_the_given_ones() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_effect(rng) for _ in range(300)]
    others = [draw_effect(rng, out_of_library()) for _ in range(100)]
    assert {effect.name() for effect in drawn} == set(library())
    assert {effect.name() for effect in others} == set(out_of_library())
    assert {effect.joints for effect in drawn} == {(1,), (2,), (3,), (1, 2), (1, 3), (2, 3), (1, 2, 3)}
    assert all(build(effect.spec()) == effect for effect in drawn + others)
    given = [draw_effect(rng, ("cogging", "base_tilt"), joints=(3,)) for _ in range(20)]
    assert {(effect.name(), effect.joints) for effect in given} == {("cogging", (3,)), ("base_tilt", (1, 2, 3))}


@pytest.mark.slow
def test_draw_is_reproducible_with_a_size_within_bounds_or_the_requested_ones(sizer: EffectSizer) -> None:
    first, second = (draw(7, RIG, SimConfig(), sizer=sizer) for _ in range(2))
    assert first == second
    (effect,) = truth(RIG, SimConfig(effects=first), seed=7)["effects"]
    assert 0.0045 <= effect["size"] <= 0.102
    assert effect["name"] == first[0].name
    names, sizes = ("torque_offset", "joint_spring"), (0.02, 0.05)
    drawn = draw(3, RIG, SimConfig(), names=names, sizes=sizes, joints=(1,), sizer=sizer)
    assert {effect.name for effect in drawn} == set(names)
    assert [effect.joints for effect in drawn] == [(1,), (1,)]
    described = truth(RIG, SimConfig(effects=drawn), seed=3, sizer=sizer)["effects"]
    assert [effect["size"] for effect in described] == pytest.approx(sizes, rel=0.02)


@pytest.mark.parametrize(
    ("names", "complaint"),
    [(("cogging",), "at least 2 effects.*1 found"), (("cogging", "coging"), "'coging' found")],
)
def test_too_few_or_unknown_names_are_explained(sizer: EffectSizer, names: tuple[str, ...], complaint: str) -> None:
    assert draw(1, RIG, SimConfig(), sizes=(), sizer=sizer) == ()
    with pytest.raises(BadInput, match=complaint):
        draw(1, RIG, SimConfig(), names=names, sizes=(0.01, 0.01), sizer=sizer)

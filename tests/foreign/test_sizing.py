"""How large effects are on the second plant."""

import pytest

from drivers.simulated.config import EffectSpec
from drivers.simulated.effect import build
from tests.foreign.sizing import EffectSizer


def test_what_the_model_absorbs_has_no_size(ruler: EffectSizer) -> None:
    carried_all_along = build(EffectSpec(name="payload_change", parameters={"dm": 1.0, "t_c": 0.0}))
    assert ruler.size(carried_all_along) < 1e-5


def test_size_grows_with_strength(ruler: EffectSizer) -> None:
    small, large = (ruler.size(build(EffectSpec(name="cogging", parameters={"a": a}))) for a in (0.2, 0.4))
    assert large == pytest.approx(2 * small, rel=1e-3)


@pytest.mark.parametrize("effect", ["stribeck", "encoder_zero_offset", "geometry_error"])
def test_the_strength_for_a_size_is_found(ruler: EffectSizer, effect: str) -> None:
    scaled = ruler.nearest(build(EffectSpec(name=effect)), 0.02)
    assert scaled is not None
    assert scaled[1] == pytest.approx(0.02, rel=0.03)
    assert ruler.size(scaled[0]) == pytest.approx(scaled[1])


def test_a_dead_band_shows_in_commanded_voltages(ruler: EffectSizer) -> None:
    assert ruler.size(build(EffectSpec(name="amplifier_deadband"))) > 1e-3

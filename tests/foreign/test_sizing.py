"""How large effects are on the second plant."""

import pytest

from drivers.simulated.config import EffectSpec
from drivers.simulated.effect import build
from tests.foreign.sizing import Ruler


def test_what_the_model_absorbs_has_no_size(ruler: Ruler) -> None:
    carried_all_along = build(EffectSpec(name="payload_change", parameters={"dm": 1.0, "t_c": 0.0}))
    assert ruler.size(carried_all_along) < 1e-5


def test_size_grows_with_strength(ruler: Ruler) -> None:
    one, two = (ruler.size(build(EffectSpec(name="cogging", parameters={"a": a}))) for a in (0.2, 0.4))
    assert two == pytest.approx(2 * one, rel=1e-3)


@pytest.mark.parametrize("effect", ["stribeck", "encoder_zero_offset", "geometry_error"])
def test_the_strength_for_a_size_is_found(ruler: Ruler, effect: str) -> None:
    found = ruler.nearest(build(EffectSpec(name=effect)), 0.02)
    assert found is not None
    assert found[1] == pytest.approx(0.02, rel=0.03)
    assert ruler.size(found[0]) == pytest.approx(found[1])


def test_a_dead_band_shows_in_commanded_voltages(ruler: Ruler) -> None:
    assert ruler.size(build(EffectSpec(name="amplifier_deadband"))) > 1e-3

"""Sizes of effects on the second plant."""

import pytest

from drivers.simulated.config import EffectSpec
from drivers.simulated.effect import build
from tests.foreign.sizing import EffectSizer


def test_effect_that_the_base_model_absorbs_has_no_size(sizer: EffectSizer) -> None:
    constant_payload = build(EffectSpec(name="payload_change", parameters={"dm": 1.0, "t_c": 0.0}))
    assert sizer.size(constant_payload) < 1e-5


@pytest.mark.parametrize("effect", ["stribeck", "encoder_zero_offset", "geometry_error"])
def test_effect_is_scaled_to_the_wanted_size(sizer: EffectSizer, effect: str) -> None:
    scaled = sizer.nearest(build(EffectSpec(name=effect)), 0.02)
    assert scaled is not None
    assert scaled[1] == pytest.approx(0.02, rel=0.03)
    assert sizer.size(scaled[0]) == pytest.approx(scaled[1])

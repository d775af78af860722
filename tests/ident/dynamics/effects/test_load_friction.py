"""Load friction with two coefficients, and load friction at low speed: what a sample with a reversal sees."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.library import load
from ident.dynamics.effects.library import stribeck_load_friction as stribeck_load
from ident.dynamics.effects.library.directional_load_friction import friction
from ident.dynamics.effects.library.stribeck import columns as stribeck
from ident.dynamics.motion import Motion


@given(st.floats(-50, 50), st.floats(-1, 1))
def test_directional_friction_is_the_mean_over_the_directions_of_a_sample(torque: float, direction: float) -> None:
    driving, driven = friction(np.array(torque), np.array(direction))
    forwards = (1 + direction) / 2
    with_load = forwards if torque > 0 else 1 - forwards
    sign = np.sign(torque)
    assert driving == pytest.approx(sign * abs(torque) * with_load, abs=1e-9)
    assert driven == pytest.approx(-sign * abs(torque) * (1 - with_load), abs=1e-9)
    assert driving + driven == pytest.approx(abs(torque) * direction, abs=1e-9)


def test_friction_of_a_load_at_any_speed_is_contained_in_that_at_low_speed() -> None:
    """So it is what is named, without an "or", where the data do not tell them apart."""
    velocity = np.linspace(-2.0, 2.0, 50)[:, None]
    inputs: Any = SimpleNamespace(motion=Motion(velocity, velocity, velocity, np.sign(velocity)), load=3 * velocity)
    simple, wide = load("load_dependent_friction"), load("stribeck_load_friction")
    assert isinstance(simple, Additive)
    assert isinstance(wide, Additive)
    assert wide.contains == load("directional_load_friction").contains == ("load_dependent_friction",)
    assert simple.formula is not None
    expected = simple.formula(inputs.load, np.sign(velocity))
    np.testing.assert_allclose(wide.columns(inputs, {"v_s": wide.shapes[0].upper})[:, :, 0], expected, rtol=0.05)


def test_stribeck_friction_of_a_load_is_that_of_each_sample_times_the_load() -> None:
    rng = np.random.default_rng(0)
    velocity, acceleration = rng.normal(0, 0.3, (2, 50, 2))
    motion = Motion(velocity, velocity, 30 * acceleration, np.sign(velocity), 0.01)
    torque: Any = rng.normal(0, 5, (50, 2))
    inputs: Any = SimpleNamespace(motion=motion, load=torque)
    expected = np.abs(torque) * stribeck(inputs, {"v_s": 0.2})[:, :, 0]
    np.testing.assert_allclose(stribeck_load.columns(inputs, {"v_s": 0.2})[:, :, 0], expected)
    instant: Any = SimpleNamespace(motion=Motion(velocity, velocity, acceleration, np.sign(velocity)), load=torque)
    formula: Any = load("stribeck_load_friction").formula  # type: ignore[attr-defined]
    at_instants = formula(torque, velocity, np.sign(velocity), 0.2)
    np.testing.assert_allclose(stribeck_load.columns(instant, {"v_s": 0.2})[:, :, 0], at_instants)

"""The instants of a payload change are suggested from the residual."""

import numpy as np
import pytest

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Shapes
from ident.dynamics.effects.library import load
from recordings.recording import Floats
from tests.ident.dynamics.given import effect_inputs

TRANSITION = 1e-3
"""Transition time of an almost instantaneous change [s]."""


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    effect = load("payload_change")
    assert isinstance(effect, Additive)
    return effect.columns(inputs, shapes)


@pytest.fixture(scope="module")
def inputs() -> EffectInputs:
    return effect_inputs(4)


@pytest.mark.parametrize(("start", "stop"), [(3.3, None), (3.3, 5.9)])
def test_the_instants_of_a_payload_are_suggested(inputs: EffectInputs, start: float, stop: float | None) -> None:
    suggest = load("payload_change").suggest
    assert suggest
    noise = np.random.default_rng(1).normal(0.0, 0.05, inputs.motion.position.shape)
    residual = 0.2 * columns(inputs, {"t_c": start, "t_e": stop or 1e9, "t_r": TRANSITION})[:, :, 0] + noise
    intervals = [(guess["t_c"], guess["t_e"]) for guess in suggest(inputs, residual)]
    expected = pytest.approx((start, stop or 1e9), abs=0.05)
    assert any(interval == expected for interval in intervals)


def test_a_payload_until_an_instant_is_suggested_as_one_from_that_instant_on(inputs: EffectInputs) -> None:
    """Heavier until an instant is equivalent to lighter from then on."""
    suggest = load("payload_change").suggest
    assert suggest
    residual = 0.2 * columns(inputs, {"t_c": -1.0, "t_e": 4.0, "t_r": TRANSITION})[:, :, 0]
    (guess,) = suggest(inputs, residual)
    assert guess["t_c"] == pytest.approx(4.0, abs=0.05)


def test_the_torque_is_continuous_in_the_instant(inputs: EffectInputs) -> None:
    early, late = (columns(inputs, {"t_c": start, "t_e": 1e9, "t_r": TRANSITION}) for start in (3.3, 3.303))
    missing = np.nansum(early - late, axis=0) / inputs.rate
    index = np.nanargmin(np.abs(inputs.time - 3.3))
    assert missing == pytest.approx(0.003 * early[index + 2], rel=0.05)


def test_suggested_instants_are_unbiased_on_decimated_inputs(inputs: EffectInputs) -> None:
    suggest = load("payload_change").suggest
    assert suggest
    decimated = inputs.decimated(8)
    errors = []
    for start in np.linspace(3.0, 3.5, 21):
        residual = columns(inputs, {"t_c": float(start), "t_e": 1e9, "t_r": TRANSITION})[::8, :, 0]
        errors.append(suggest(decimated, residual)[0]["t_c"] - start)
    assert abs(np.mean(errors)) < 0.2 * 8 / inputs.rate


def test_the_mass_changes_linearly_during_the_transition(inputs: EffectInputs) -> None:
    share = (
        columns(inputs, {"t_c": 3.3, "t_e": 1e9, "t_r": 0.2})[:, :, 0]
        / columns(inputs, {"t_c": 0.0, "t_e": 1e9, "t_r": TRANSITION})[:, :, 0]
    )
    at_instants = np.interp([3.19, 3.25, 3.3, 3.35, 3.41], inputs.time, share[:, 0])
    assert at_instants == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0], abs=0.01)

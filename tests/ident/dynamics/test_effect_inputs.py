"""Inputs of effects."""

from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats, Recording
from tests.ident.dynamics.given import effect_inputs

BANDWIDTH = 20.0


@pytest.fixture(scope="module")
def inputs() -> EffectInputs:
    return effect_inputs(2, cutoff=BANDWIDTH)


def _inside(inputs: EffectInputs, x: Floats) -> Floats:
    """Cut off the ends, where the filter has no output."""
    return x[np.isfinite(inputs.motion.acceleration).all(axis=1)][50:-50]


def test_low_passing_removes_a_disturbance_above_the_bandwidth(inputs: EffectInputs) -> None:
    disturbance = 5.0 * np.sin(2 * np.pi * 2.5 * BANDWIDTH * inputs.time)[:, None]
    disturbed = replace(inputs, motion=replace(inputs.motion, acceleration=inputs.motion.acceleration + disturbance))
    smooth = disturbed.low_passed.motion
    assert np.abs(_inside(inputs, smooth.acceleration - inputs.motion.acceleration)).max() < 0.1
    assert np.abs(_inside(inputs, smooth.position - inputs.motion.position)).max() < 2e-4
    rough, half, without = (disturbed.flexible_joints(0.0, smoothing).torque for smoothing in (0.0, 0.5, 1.0))
    np.testing.assert_allclose(half, (rough + without) / 2, atol=1e-9)
    assert np.abs(_inside(inputs, rough - without)).max() > 0.5
    assert smooth.direction is inputs.motion.direction


def test_instants_without_filter_output_keep_their_values(inputs: EffectInputs) -> None:
    known = np.isfinite(inputs.motion.velocity)
    assert (np.isfinite(inputs.low_passed.motion.velocity) == known).all()


def test_load_of_the_gears_has_the_effects_on_the_arms(make: object, truth: Floats) -> None:
    recording: Recording = make(cycles=2, rate=250.0)  # type: ignore[operator]
    prepared = prepare(recording, "parallel", BANDWIDTH)
    structure = prepared.base_structure
    for name in ("air_drag", "torque_offset", "load_dependent_friction"):
        structure = structure.with_term(Term.on_all_joints(name, library()[name], structure.rig))
    drag, offset, share = 0.5, 0.3, 0.1
    without, with_load = (
        TorquePredictor(prepared).effect_inputs(structure, np.array([*truth, c, *[offset] * 3, *[share] * 3]))
        for c in (0.0, drag)
    )
    drag_torque = structure.terms[0].effect.columns(with_load, {})[:, :, 0] * drag  # type: ignore[union-attr]
    np.testing.assert_allclose(without.load, without.rigid)  # an offset is of the motor
    np.testing.assert_allclose(with_load.load, with_load.rigid + drag_torque)
    lost = structure.terms[2].effect.columns(with_load, {})[:, :, 0]  # type: ignore[union-attr]
    np.testing.assert_allclose(lost, np.abs(with_load.load) * with_load.motion.direction)

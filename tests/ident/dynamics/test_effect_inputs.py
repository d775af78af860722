"""What effects see of a motion."""

from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effect_inputs import EffectInputs
from recordings.recording import Floats, Recording

BANDWIDTH = 20.0


@pytest.fixture(scope="module")
def view(make: object, truth: Floats) -> EffectInputs:
    recording: Recording = make(cycles=2, rate=250.0)  # type: ignore[operator]
    course = prepare(recording, "parallel", BANDWIDTH)
    return course.as_recorded.effect_inputs(course, truth)


def _inside(view: EffectInputs, x: Floats) -> Floats:
    """Away from the ends, where nothing can be filtered."""
    return x[np.isfinite(view.motion.acceleration).all(axis=1)][50:-50]


def test_a_calmed_view_has_the_same_motion_without_what_shakes_it(view: EffectInputs) -> None:
    shake = 5.0 * np.sin(2 * np.pi * 2.5 * BANDWIDTH * view.time)[:, None]
    shaken = replace(view, motion=replace(view.motion, acceleration=view.motion.acceleration + shake))
    calm = shaken.low_passed().motion
    assert np.abs(_inside(view, calm.acceleration - view.motion.acceleration)).max() < 0.1
    assert np.abs(_inside(view, calm.position - view.motion.position)).max() < 2e-4
    half = shaken.low_passed(0.5).motion
    left = _inside(view, half.acceleration - view.motion.acceleration)
    assert np.abs(left).max() == pytest.approx(2.5, rel=0.05)
    assert calm.direction is view.motion.direction


def test_what_cannot_be_filtered_stays_as_it_is(view: EffectInputs) -> None:
    known = np.isfinite(view.motion.velocity)
    assert (np.isfinite(view.low_passed().motion.velocity) == known).all()
    assert view.low_passed(0.0) is view

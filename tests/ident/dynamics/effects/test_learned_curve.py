"""Learned curves are effects like others."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.learned_curve import LearnedCurve, effect_file_text, learned_effect
from ident.dynamics.effects.user_files import from_file
from recordings.recording import Floats, Recording

SPRING = LearnedCurve(2, "position", 3, "one", (-1.0, 0.0, 1.0), (-4.0, 0.0, 8.0))


@pytest.fixture(scope="module")
def view(make: object, truth: Floats) -> EffectInputs:
    recording: Recording = make(cycles=1, rate=100.0)  # type: ignore[operator]
    course: PreparedRecording = prepare(recording, "parallel", 20.0)
    return course.as_recorded.effect_inputs(course, truth)


def test_it_is_straight_between_knots_and_acts_on_its_joint_only(view: EffectInputs) -> None:
    (torque,) = np.moveaxis(learned_effect([SPRING]).columns(view, {}), 2, 0)
    place = view.motion.position[:, 2]
    known = np.isfinite(torque[:, 1])
    assert known.mean() > 0.8
    np.testing.assert_allclose(torque[known, 1], (np.where(place > 0, 8.0, 4.0) * place)[known])
    assert not np.nan_to_num(torque[:, [0, 2]]).any()


@pytest.mark.parametrize("variable", ["position", "velocity", "acceleration", "load", "time"])
def test_it_may_be_over_any_variable(view: EffectInputs, variable: str) -> None:
    level = replace(SPRING, variable=variable, values=(2.0, 2.0, 2.0))  # type: ignore[arg-type]
    np.testing.assert_allclose(np.nan_to_num(level.torque(view), nan=2.0), 2.0)


def test_it_may_turn_with_the_motion_and_grow_with_speed(view: EffectInputs) -> None:
    level = replace(SPRING, values=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(replace(level, times="direction").torque(view), view.motion.direction[:, 1])
    np.testing.assert_allclose(replace(level, times="velocity").torque(view), view.motion.velocity[:, 1])


def test_its_file_is_an_effect(view: EffectInputs, tmp_path: Path) -> None:
    path = tmp_path / "curve.py"
    path.write_text(effect_file_text([SPRING], "run.mcap"))
    effect = from_file(path)
    np.testing.assert_array_equal(effect.columns(view, {}), learned_effect([SPRING]).columns(view, {}))  # type: ignore[union-attr]

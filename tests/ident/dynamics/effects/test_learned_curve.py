"""Learned curves in the form of an effect."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.learned_curve import LearnedCurve, effect_file_text, learned_effect
from ident.dynamics.effects.user_files import from_file
from tests.ident.dynamics.given import effect_inputs

SPRING = LearnedCurve(2, "position", 3, "one", (-1.0, 0.0, 1.0), (-4.0, 0.0, 8.0))


@pytest.fixture(scope="module")
def inputs() -> EffectInputs:
    return effect_inputs(1, 100.0, 20.0)


def test_a_curve_is_linear_between_knots_and_acts_on_its_joint_only(inputs: EffectInputs) -> None:
    (torque,) = np.moveaxis(learned_effect([SPRING]).columns(inputs, {}), 2, 0)
    position = inputs.motion.position[:, 2]
    known = np.isfinite(torque[:, 1])
    assert known.mean() > 0.8
    np.testing.assert_allclose(torque[known, 1], (np.where(position > 0, 8.0, 4.0) * position)[known])
    assert not np.nan_to_num(torque[:, [0, 2]]).any()


@pytest.mark.parametrize("variable", ["position", "velocity", "acceleration", "load", "time"])
def test_a_curve_may_be_over_any_variable(inputs: EffectInputs, variable: str) -> None:
    level = replace(SPRING, variable=variable, values=(2.0, 2.0, 2.0))  # type: ignore[arg-type]
    np.testing.assert_allclose(np.nan_to_num(level.torque(inputs), nan=2.0), 2.0)


def test_a_curve_may_be_multiplied_by_direction_or_velocity(inputs: EffectInputs) -> None:
    level = replace(SPRING, values=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(replace(level, multiplier="direction").torque(inputs), inputs.motion.direction[:, 1])
    np.testing.assert_allclose(replace(level, multiplier="velocity").torque(inputs), inputs.motion.velocity[:, 1])


def test_the_written_file_is_the_same_effect(inputs: EffectInputs, tmp_path: Path) -> None:
    path = tmp_path / "curve.py"
    path.write_text(effect_file_text([SPRING], "run.mcap"))
    effect = from_file(path)
    np.testing.assert_array_equal(effect.columns(inputs, {}), learned_effect([SPRING]).columns(inputs, {}))  # type: ignore[union-attr]

"""An effect on some joints: its shapes, shared or of each joint."""

from dataclasses import replace

import numpy as np

from ident.dynamics.effects.library import load
from ident.dynamics.structure import Term

FRICTION = Term("position_dependent_friction", load("position_dependent_friction"), (0, 2))
STRIBECK = Term("stribeck", load("stribeck"), (0, 2))


def test_local_shapes_start_at_what_all_recordings_together_suggest() -> None:
    first = {"low": np.array([-1.0, -9.0, -0.2]), "high": np.array([0.5, 9.0, 0.3])}
    second = {"low": np.array([-0.8, -9.0, -0.4]), "high": np.array([0.7, 9.0, np.nan])}
    (guess,) = FRICTION.shape_guesses([first, second])
    np.testing.assert_array_equal(guess, [-1.0, 0.7, -0.4, 0.3])


def test_local_shapes_start_at_the_declared_values_where_nothing_is_suggested() -> None:
    (guess,) = FRICTION.shape_guesses([])
    np.testing.assert_array_equal(guess, [-1.0, 1.0, -1.0, 1.0])


def test_shared_shapes_start_at_the_declared_values_and_at_each_suggestion() -> None:
    declared = [[value] for value in STRIBECK.effect.shapes[0].initial_guesses]
    guesses = STRIBECK.shape_guesses([{"v_s": 0.123}, {"v_s": 0.456}])
    assert [guess.tolist() for guess in guesses] == [*declared, [0.123], [0.456]]


def test_every_instance_has_its_columns_and_its_torque() -> None:
    columns = np.random.default_rng(0).normal(size=(5, 3, 9))
    coefficients = np.random.default_rng(1).normal(size=(2, 9))
    torque = FRICTION.torque(columns, coefficients)
    np.testing.assert_allclose(FRICTION.by_instance(columns) @ coefficients.ravel(), torque)
    np.testing.assert_array_equal(torque[:, 1], 0)
    np.testing.assert_allclose(replace(FRICTION, joints=(2,)).torque(columns, coefficients[1:])[:, 2], torque[:, 2])

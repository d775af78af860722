"""An effect on some joints: its shapes, shared or of each joint."""

from dataclasses import replace

import numpy as np
import pytest

from ident.dynamics.effects.base import Suggestion
from ident.dynamics.effects.library import load
from ident.dynamics.structure import Term

FRICTION = Term("position_dependent_friction", load("position_dependent_friction"), (0, 2))
STRIBECK = Term("stribeck", load("stribeck"), (0, 2))


TRAVELS = [
    {"low": np.array([-1.0, -9.0, -0.2]), "high": np.array([0.5, 9.0, 0.3])},
    {"low": np.array([-0.8, -9.0, -0.4]), "high": np.array([0.7, 9.0, np.nan])},
]
DECLARED = [[value] for value in STRIBECK.effect.shapes[0].initial_guesses]


@pytest.mark.parametrize(
    ("term", "suggestions", "guesses"),
    [
        (FRICTION, TRAVELS, [[-1.0, 0.7, -0.4, 0.3]]),
        (FRICTION, [], [[-1.0, 1.0, -1.0, 1.0]]),
        (STRIBECK, [{"v_s": 0.123}, {"v_s": 0.456}], [*DECLARED, [0.123], [0.456]]),
    ],
    ids=["over all recordings", "declared", "shared by the joints"],
)
def test_shapes_start_at_what_is_declared_and_suggested(
    term: Term, suggestions: list[Suggestion], guesses: list[list[float]]
) -> None:
    assert [guess.tolist() for guess in term.shape_guesses(suggestions)] == guesses


def test_every_instance_has_its_columns_and_its_torque() -> None:
    columns = np.random.default_rng(0).normal(size=(5, 3, 9))
    coefficients = np.random.default_rng(1).normal(size=(2, 9))
    torque = FRICTION.torque(columns, coefficients)
    np.testing.assert_allclose(FRICTION.by_instance(columns) @ coefficients.ravel(), torque)
    np.testing.assert_array_equal(torque[:, 1], 0)
    np.testing.assert_allclose(replace(FRICTION, joints=(2,)).torque(columns, coefficients[1:])[:, 2], torque[:, 2])

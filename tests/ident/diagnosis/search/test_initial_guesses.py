"""Initial guesses at which the columns of an effect are tried."""

import numpy as np
import pytest

from ident.diagnosis.search.initial_guesses import initial_guesses
from ident.dynamics.effects.base import Suggestion
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from tests.ident import building

LIBRARY = library()


def term(name: str, joints: int = 2) -> Term:
    return Term.on_all_joints(name, LIBRARY[name], building.bench(joints))


def test_coefficients_are_tried_at_one_at_every_declared_shape() -> None:
    (shape,) = LIBRARY["stribeck"].shapes
    guesses = initial_guesses(term("stribeck"), [])
    assert [values.tolist() for _, values in guesses] == [[value] for value in shape.initial_guesses]
    assert all((local == np.ones((2, 1))).all() for local, _ in guesses)


def test_parameters_of_a_signal_are_tried_where_the_effect_declares() -> None:
    delay = term("actuation_delay")
    guesses = initial_guesses(delay, [])
    (parameter,) = delay.local_parameters
    assert [local[0, 0] for local, _ in guesses] == list(parameter.initial_guesses)
    assert all(local.shape == (delay.instances, 1) for local, _ in guesses)


def test_suggested_parameters_and_shapes_are_tried_too_and_once() -> None:
    delay = term("actuation_delay")
    more = initial_guesses(delay, [{"delta": 0.004}, {"delta": 0.004}])
    assert len(more) == len(initial_guesses(delay, [])) + 1
    assert (more[-1][0] == 0.004).all()


@pytest.mark.parametrize("speed", [0.123, 0.456])
def test_suggested_shape_comes_after_the_declared_ones(speed: float) -> None:
    stribeck = term("stribeck")
    suggestion: Suggestion = {stribeck.effect.shapes[0].name: speed}
    assert initial_guesses(stribeck, [suggestion])[-1][1] == pytest.approx([speed])

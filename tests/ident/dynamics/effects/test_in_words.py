"""The size of an effect in words, as its file puts it."""

import numpy as np
import pytest

from ident.dynamics.effects.base import INFINITE_TIME, Quantity
from ident.dynamics.effects.in_words import size_in_words
from ident.dynamics.effects.library import library
from recordings.rig import Axis, Rig
from tests.ident import building

BENCH = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis(type="prismatic")))


@pytest.mark.parametrize(
    ("name", "joint", "local", "shapes", "expected"),
    [
        ("cogging", 0, [[0.3, 0.4]], [14.002], "0.5 N m, 14 times per turn"),
        ("cogging", 1, [[30.0, 40.0]], [159.99], "50 N, 160 times per 2π m"),
        ("cogging", 0, [[0.3, 0.4], [0.6, 0.8]], [14.5], "0.5 to 1 N m, 14.5 times per turn"),
        ("load_dependent_friction", 0, [[0.0304]], [], "3 % of the load"),
        ("backlash", 0, [[0.0021]], [0.3], "± 0.0021 rad"),
        ("payload_change", 0, [[1.5]], [INFINITE_TIME, INFINITE_TIME, 0.05], "1.5 kg, at never"),
        ("position_torque", 0, [[0.1] * 8 + [-0.7]], [0.0, 1.0], "up to 0.7 N m"),
        ("air_drag", 0, [[123.4]], [], "123 N s^2/m^2"),
    ],
)
def test_an_effect_says_its_size(
    name: str, joint: int, local: list[list[float]], shapes: list[float], expected: str
) -> None:
    assert size_in_words(library()[name], BENCH, joint, np.array(local), np.array([shapes])) == expected


def test_an_effect_of_the_user_lists_its_parameters() -> None:
    mine = building.effect(building.drag, shapes=(Quantity(name="w", unit="{position}", meaning="width"),))
    assert size_in_words(mine, BENCH, 0, np.array([[0.3]]), np.array([[2.0]])) == "a = 0.3 N m, w = 2 rad"


@pytest.mark.parametrize("name", library())
def test_every_effect_of_the_library_has_a_size(name: str) -> None:
    effect = library()[name]
    text = size_in_words(effect, BENCH, 0, np.ones((1, len(effect.parameters))), effect.typical_shapes[None])
    assert text.strip()
    assert "{" not in text

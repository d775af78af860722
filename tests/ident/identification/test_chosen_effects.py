"""Effects that the user chooses by name."""

from dataclasses import replace

import pytest

from ident.dynamics.effects.library import library
from ident.identification.chosen_effects import parse_terms
from recordings.errors import BadInput
from recordings.rig import Axis, Rig
from tests.ident import building

LIBRARY = library()


def test_effects_on_all_or_some_joints_are_parsed() -> None:
    terms = parse_terms(["stribeck", "torque_offset:2"], LIBRARY, building.record(2))
    assert [(term.name, term.joints) for term in terms] == [("stribeck", (0, 1)), ("torque_offset", (1,))]


def test_without_numbers_an_effect_is_on_the_joints_that_can_have_it() -> None:
    axes = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis(type="prismatic")))
    recording = replace(building.record(2), rig=axes)
    assert parse_terms(["axis_weight"], LIBRARY, recording)[0].joints == (0,)
    with pytest.raises(BadInput, match=r"cannot be on joint 2: On a prismatic joint weight is a torque_offset\."):
        parse_terms(["axis_weight:1,2"], LIBRARY, recording)


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        (["stribek"], "a name of the library expected, 'stribek' found; did you mean stribeck?"),
        (["qqq"], "'qqq' found; `ident effects` lists them"),
        (["stribeck", "stribeck:1"], "every effect once expected, 'stribeck' found twice"),
        (["air_drag"], "mechanism delta expected, axes found"),
        (["amplifier_saturation"], "cannot be seen in such a recording"),
        (["temperature_friction"], "No temperature was recorded"),
        (["stribeck:3"], "joints 1 to 2, such as stribeck:1,2, expected, '3' found"),
        (["stribeck:1,1"], "'1,1' found"),
        (["stribeck:a"], "'a' found"),
    ],
)
def test_wrong_choice_is_refused(choices: list[str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        parse_terms(choices, LIBRARY, building.record(2))

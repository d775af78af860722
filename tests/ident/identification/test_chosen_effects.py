"""Effects that the user chooses by name."""

import pytest

from ident.dynamics.effects.library import library
from ident.identification.chosen_effects import parse_terms
from recordings.errors import BadInput
from tests.ident import building

LIBRARY = library()


def test_effects_on_all_or_some_joints_are_parsed() -> None:
    terms = parse_terms(["stribeck", "torque_offset:2"], LIBRARY, building.record(2))
    assert [(term.name, term.joints) for term in terms] == [("stribeck", (0, 1)), ("torque_offset", (1,))]


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        (["nonsense"], "effect: one of .*stribeck.* expected, 'nonsense' found"),
        (["stribeck", "stribeck:1"], "every effect once expected, 'stribeck' found twice"),
        (["air_drag"], "mechanism delta expected, axes found"),
        (["amplifier_saturation"], "cannot be seen in such a recording"),
        (["stribeck:3"], "joints 1 to 2, such as stribeck:1,2, expected, '3' found"),
        (["stribeck:1,1"], "'1,1' found"),
        (["stribeck:a"], "'a' found"),
    ],
)
def test_wrong_choice_is_refused(choices: list[str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        parse_terms(choices, LIBRARY, building.record(2))

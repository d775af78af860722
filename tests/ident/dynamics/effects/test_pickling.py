"""Effects are pickled by name, by their file, or by their formula: their functions have no names."""

import pickle
from pathlib import Path

import pytest

from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.learned_curve import LearnedCurve, learned_effect
from ident.dynamics.effects.library import library, load, names
from ident.identification.saved_formula import saved_formula

SOURCE = """
from ident.dynamics.effects.base import Additive, Quantity
effect = Additive(sentence="s", symptom="s", causes="c", remedy="r", axis="velocity", formula=lambda qd: qd**3,
    parameters=(Quantity(name="a", unit="{effort}", meaning="m"),))
"""


def again(effect: Effect) -> Effect:
    found = pickle.loads(pickle.dumps(effect))
    assert isinstance(found, Effect)
    return found


@pytest.mark.parametrize("name", names())
def test_an_effect_of_the_library_is_itself(name: str) -> None:
    assert again(load(name)) is load(name)


def test_a_changed_effect_keeps_its_changes() -> None:
    changed = load("stribeck").changed(joints=(1,))
    assert again(changed) == changed
    assert changed.joints == (1,)


def test_an_effect_of_the_user_needs_its_file_no_more(tmp_path: Path) -> None:
    file = tmp_path / "cubic.py"
    file.write_text(SOURCE)
    effect = library([file])["cubic"]
    file.unlink()
    assert again(effect).equation == effect.equation
    saved = saved_formula(effect)
    assert saved is not None
    assert saved_formula(again(saved.effect("cubic"))) == saved


def test_a_learned_curve_is_pickled_by_its_values() -> None:
    curve = LearnedCurve(1, "position", 1, knots=(0.0, 1.0), values=(0.1, 0.2))
    assert again(learned_effect([curve])).parameters == learned_effect([curve]).parameters

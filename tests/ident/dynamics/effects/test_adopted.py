"""Adopted effects: a folder that every command reads; a formula as data, which runs no code."""

from pathlib import Path

import pytest

from ident.dynamics.effects import adopted
from ident.dynamics.effects.library import library
from ident.identification.saved_formula import SavedFormula, saved_formula
from recordings.errors import BadInput

LAW = '''
"""A law."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="A law.",
    symptom="See the formula.",
    causes="not known",
    remedy="look at it",
    axis="velocity",
    formula=lambda q1, qd, s: np.maximum(q1 - s, 0) * qd,
    parameters=(Quantity(name="a", unit="{effort} s/{position}^2", meaning="coefficient"),),
    shapes=(Quantity(name="s", unit="{position}", meaning="begin", lower=-1.0, upper=1.0, initial_guesses=(0.1,)),),
)
'''


@pytest.fixture
def law(tmp_path: Path) -> Path:
    path = tmp_path / "law.py"
    path.write_text(LAW)
    return path


def test_adopted_effect_is_one_of_the_library_until_it_is_dropped(
    law: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(adopted.FOLDER, str(tmp_path / "mine"))
    adopted.adopt(law)
    assert library()["law"].equation == "a maximum(q1 - s, 0) v"
    with pytest.raises(BadInput, match="a name of its own expected"):
        adopted.adopt(law)
    adopted.adopt(law, force=True)
    adopted.drop("law")
    assert "law" not in library()
    with pytest.raises(BadInput, match="an adopted one expected"):
        adopted.drop("law")


def test_empty_variable_leaves_adopted_effects_out(law: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(adopted.FOLDER, "")
    assert adopted.files() == []
    with pytest.raises(BadInput, match="a folder for adopted effects expected"):
        adopted.adopt(law)


def test_formula_survives_as_data(law: Path) -> None:
    effect = library([law])["law"]
    saved = saved_formula(effect)
    assert saved is not None
    assert saved.columns == ("maximum(q1 - s, 0) * qd",)
    again = SavedFormula.model_validate_json(saved.model_dump_json()).effect("law")
    assert (again.equation, again.parameters, again.shapes) == (effect.equation, effect.parameters, effect.shapes)
    assert saved_formula(again) == saved


def test_code_in_a_model_is_refused_and_not_run(law: Path, tmp_path: Path) -> None:
    saved = saved_formula(library([law])["law"])
    assert saved is not None
    trap = tmp_path / "trap"
    wrong = saved.model_copy(update={"columns": (f"__import__('pathlib').Path({str(trap)!r}).touch()",)})
    with pytest.raises(BadInput, match="formula: "):
        wrong.effect("law")
    assert not trap.exists()


def test_effect_that_is_more_than_a_formula_is_no_data() -> None:
    assert saved_formula(library()["presliding_hysteresis"]) is None
    assert saved_formula(library()["stribeck"]) is None
    assert saved_formula(library()["quadratic_friction"]) is not None

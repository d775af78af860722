"""Scores of formulas: what a hidden law uses, and how near the right model a formula comes."""

from collections import Counter

import pytest

from benchmarks.formulas.cases import cases
from benchmarks.formulas.scoring import is_right, score
from benchmarks.formulas.tables import lines
from tests.foreign.beyond_library import QUANTITIES

CABLE = {"name": "tangled_cables", "joints": [1, 3], "parameters": {"k": 2.0}, "in_library": False}
FRICTION = {
    "name": "friction_of_other",
    "joints": [2],
    "parameters": {"a": 0.3, "phase": 0.0, "ahead": 1.5},
    "in_library": False,
}
NONE = {"columns": [], "joints": [], "terms": 0}
SPRING = {"name": "joint_spring", "joints": [1], "parameters": {"k": 1.0, "q_0": 0.0}, "in_library": True}


@pytest.mark.parametrize(
    ("columns", "joints", "effect", "right"),
    [
        (["(q1 - q3)"], [1, 3], CABLE, True),
        (["q"], [1], CABLE, False),
        (["(q1 - q2)"], [1, 2], CABLE, False),
        (["direction * sin(n3 * q3)", "direction * cos(n3 * q3)"], [2], FRICTION, True),
        (["tanh(qd / v) * q3"], [2], FRICTION, True),
        (["direction * t * q3"], [2], FRICTION, False),
        (["direction * q3"], [1], FRICTION, False),
        (["q"], [1], SPRING, False),
    ],
)
def test_formula_is_right_if_it_uses_what_the_law_uses(
    columns: list[str], joints: list[int], effect: dict[str, object], right: bool
) -> None:
    assert is_right(columns, joints, [effect]) is right


def test_table_compares_with_the_right_model() -> None:
    case = next(each for each in cases("outside", "chosen") if each.effects == ("tangled_cables",))
    formula = {"columns": ["(q1 - q3)"], "joints": [1, 3], "terms": 1}
    errors = {"before": [3.0, 4.0], "after": [0.6, 0.8], "floor": [0.0, 0.8]}
    line = errors | {"propose_seconds": 2.0}
    scored = [
        score(case, {"effects": [CABLE]}, line | {"formula": formula}),
        score(case, {"effects": [CABLE]}, line | {"formula": NONE, "after": line["before"]}),
        score(case, {"effects": [CABLE]}, {"case": case.name, "error": "BadInput: no"}),
    ]
    assert [each.right for each in scored] == [True, False, False]
    assert [each.after for each in scored[:2]] == pytest.approx([1.25, 6.25])
    table = list(lines(scored))
    assert table[1].split()[1:] == ["3", "1", "1", "0", "6.25", "6.25", "0", "1.0", "2.0"]
    assert table[-1].endswith("inf to inf: BadInput: no")


@pytest.mark.parametrize("part", ["tuned", "chosen", "locked"])
def test_first_cases_have_all_laws_equally_often(part: str) -> None:
    drawn = cases("outside", part, "0123")[:60]
    assert Counter(case.effects[0] for case in drawn) == dict.fromkeys(QUANTITIES, 5)
    assert len({case.seed for case in drawn}) == 60
    assert not cases("nothing", part)[0].effects
    assert cases("outside", "locked", "4567")[0].name != cases("outside", "locked", "0123")[0].name

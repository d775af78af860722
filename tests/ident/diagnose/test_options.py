"""What could be added to a model."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.composition import Term
from ident.diagnose.options import CLEAR, Finder
from ident.effects import library

ROWS = 1000.0


def state(effect: str, loss: float, parameters: int) -> Any:
    solution = SimpleNamespace(loss=loss, x=np.zeros(parameters))
    return SimpleNamespace(solution=solution, terms=(Term(effect, library()[effect], (1,)),))


@pytest.mark.parametrize(
    ("other", "loss", "expected"),
    [
        ("joint_spring", ROWS, True),
        ("joint_spring", ROWS - 0.9 * CLEAR, True),
        ("joint_spring", ROWS - 1.1 * CLEAR, False),
        ("arm_mass_mismatch", ROWS, False),
    ],
)
def test_what_contains_another_is_none_beside_it_unless_it_explains_more(
    other: str, loss: float, expected: bool
) -> None:
    finder = Finder(SimpleNamespace(independent_rows=ROWS), library())  # type: ignore[arg-type]
    assert finder.no_more("torque_offset", state("torque_offset", ROWS, 13), state(other, loss, 14)) is expected

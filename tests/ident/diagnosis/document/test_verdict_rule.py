"""The verdict, rule by rule."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.document.document import Verdict
from ident.diagnosis.document.verdict_rule import Remainder, verdict_of

NOISE = Remainder(np.array([0.1]), np.array([0.1]), np.array([0.12]), np.array([5.0]), structured=False)
LARGE = replace(NOISE, rms=np.array([1.0]))
STRUCTURED = replace(LARGE, structured=True)
COARSE = replace(NOISE, torque=np.array([1.0]))
"""A structured residual of 3 % of the torque would not exceed the limit."""


@pytest.mark.parametrize(
    ("left", "found", "taken", "verdict"),
    [
        (NOISE, False, 0.0, "adequate"),
        (COARSE, False, 0.0, "undetermined"),
        (NOISE, True, 0.9, "missing-effect"),
        (LARGE, True, 0.5, "missing-effect"),
        (LARGE, True, 0.09, "unknown-structure"),  # a trifle beside a large remainder
        (LARGE, False, 0.0, "undetermined"),
        (STRUCTURED, False, 0.0, "unknown-structure"),
        (STRUCTURED, True, 0.9, "unknown-structure"),
    ],
)
def test_first_rule_that_applies_decides(left: Remainder, found: bool, taken: float, verdict: Verdict) -> None:
    assert verdict_of(False, left, found, taken) == verdict
    assert verdict_of(True, left, found, taken) == "implausible-data"

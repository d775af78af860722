"""Cases of the golden results."""

from benchmarks.hidden_effects.parts import cases
from tests.golden.cases import CASES


def test_cases_are_in_the_benchmark() -> None:
    assert {case.benchmark for case in CASES if case.benchmark} <= {case.name for case in cases("foreign", "tuned")}

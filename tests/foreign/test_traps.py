"""Traps: what no effect of the library is must not be believed to be one."""

import pytest

from benchmarks.hidden_effects.traps import diagnose_trap, false_names
from tests.foreign import traps

pytestmark = pytest.mark.slow

SEEDS = (2, 3)
"""One with a held-out recording and one without; the benchmark has more."""


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", traps.KINDS)
def test_trap_is_not_believed(kind: traps.Kind, seed: int) -> None:
    assert false_names(kind, diagnose_trap(kind, seed)) == []


@pytest.mark.parametrize("kind", ["undeclared_weight", "sublinear_friction"])
def test_trap_leaves_structure_that_is_called_unknown(kind: traps.Kind) -> None:
    assert diagnose_trap(kind, 3).verdict == "unknown-structure"

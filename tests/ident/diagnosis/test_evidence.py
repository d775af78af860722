"""Whether one model is better than another."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.improvement import measure_improvement

RATE = 40.0


def test_a_candidate_that_knows_nothing_of_a_block_is_compared_on_the_others() -> None:
    rng = np.random.default_rng(0)
    before = rng.normal(0.0, 2.0, (400, 1))
    after = before / 2
    after[:30] = np.nan
    rows = np.ones(before.shape, bool)
    material: Any = SimpleNamespace(held=[rows], datasets=[SimpleNamespace(time=np.arange(400) / RATE)])
    found = measure_improvement(material, [before], [after], np.ones(1))
    same = measure_improvement(material, [np.where(np.isfinite(after), before, np.nan)], [after], np.ones(1))
    assert found == same
    assert found.reduction == pytest.approx(3.0, rel=0.2)

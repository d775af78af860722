"""The improvement of one model over another."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.improvement import measure_improvement

RATE = 40.0


def test_rows_where_one_model_is_undefined_are_not_compared() -> None:
    rng = np.random.default_rng(0)
    before = rng.normal(0.0, 2.0, (400, 1))
    after = before / 2
    after[:30] = np.nan
    rows = np.ones(before.shape, bool)
    split: Any = SimpleNamespace(test=[rows], datasets=[SimpleNamespace(time=np.arange(400) / RATE)])
    improvement = measure_improvement(split, [before], [after], np.ones(1))
    expected = measure_improvement(split, [np.where(np.isfinite(after), before, np.nan)], [after], np.ones(1))
    assert improvement == expected
    assert improvement.reduction == pytest.approx(3.0, rel=0.2)

"""Resolution of rounded and of continuous values."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.resolution import resolution


@given(step=st.floats(1e-7, 1e3), offset=st.floats(-1, 1), seed=st.integers(0, 100), size=st.integers(50, 500))
def test_step_of_rounded_values_is_found(step: float, offset: float, seed: int, size: int) -> None:
    counts = np.random.default_rng(seed).integers(-300, 300, size)
    counts[:3] = 0, 1, 2
    assert resolution(counts * step + offset * step) == pytest.approx(step, rel=1e-6)


@given(seed=st.integers(0, 100))
def test_continuous_values_have_none(seed: int) -> None:
    assert resolution(np.random.default_rng(seed).normal(size=500)) is None


@pytest.mark.parametrize("values", [[], [1.0], [1.0, 2.0], [np.nan, np.nan], [0.0, 1.0, np.nan]])
def test_few_levels_have_none(values: list[float]) -> None:
    assert resolution(np.array(values)) is None

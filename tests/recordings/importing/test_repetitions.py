"""Repetitions of an imported motion, and the time between its samples."""

import numpy as np
import pytest

from recordings.importing.repetitions import mean_step


@pytest.mark.parametrize("unit", [1, 10, 256, 1000, 100_000])
def test_rounded_times_do_not_change_the_step(unit: int) -> None:
    stamp = np.rint(np.arange(5000) * 2_000_000 / unit).astype(np.int64) * unit
    assert mean_step(stamp) == pytest.approx(2_000_000, rel=1e-5)


def test_a_gap_holds_several_steps() -> None:
    stamp = np.delete(np.arange(5000) * 2_000_000, slice(1000, 3500)) + np.random.default_rng(0).integers(
        0, 300, 2500
    )
    assert mean_step(stamp) == pytest.approx(2_000_000, rel=1e-6)

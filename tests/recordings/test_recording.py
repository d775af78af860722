"""What follows from the samples of a recording."""

from dataclasses import replace

import numpy as np
import pytest

from recordings.recording import IMPORTED
from tests.ident import building

NAN = np.nan
CASES: dict[str, tuple[list[float], list[float], list[float], str]] = {
    "an answer shows how the target of the cycle before was reached": (
        *([0.0, 1.0, 2.0, 3.0], [0.0, 0.0, 0.9, 2.0]),
        [NAN, 0.0, 0.1, 0.0],
        "fig5a",
    ),
    "the last target stays while cycles are missed": (
        *([1.0, 2.0, NAN, NAN, 3.0, 4.0], [0.0, 1.0, NAN, NAN, 1.9, 3.0]),
        [NAN, 0.0, NAN, NAN, 0.1, 0.0],
        "fig5a",
    ),
    "before and after the motion there is none": (
        *([NAN, 1.0, 2.0, NAN], [1.0, 1.0, NAN, 2.0]),
        [NAN, NAN, NAN, NAN],
        "fig5a",
    ),
    "imported targets are of the same instant": ([1.0, 2.0], [0.9, 2.0], [0.1, 0.0], IMPORTED),
}
"""Command, position, following error, and trajectory."""


@pytest.mark.parametrize("case", CASES)
def test_following_error(case: str) -> None:
    command, position, expected, trajectory = CASES[case]
    recording = building.record()
    run = recording.run.model_copy(update={"trajectory": trajectory})
    columns = np.array([command, position])[:, :, None]
    made = replace(recording, run=run, time=recording.time[: len(command)], command=columns[0], position=columns[1])
    np.testing.assert_allclose(made.following_error[:, 0], expected, atol=1e-12)


def test_rows_that_are_lost_are_a_gap_and_no_following_error() -> None:
    whole = building.record()
    assert whole.longest_gap == 0
    keep = np.r_[0:100, 150 : len(whole.time)]
    holed = replace(whole, time=whole.time[keep], command=whole.command[keep], position=whole.position[keep])
    assert holed.longest_gap == pytest.approx(51 / whole.run.rate)
    expected = whole.following_error[keep]
    expected[100] = np.nan
    np.testing.assert_array_equal(holed.following_error, expected)

"""A rate is counted from the first results on, by when they were finished; the table follows from rates."""

from pathlib import Path

import pytest

from benchmarks.fleet import throughput
from recordings.errors import BadInput


def test_rate_leaves_the_start_out() -> None:
    assert throughput._rate([100.0, 104.0, 90.0, 50.0, 101.0, 103.0]) == pytest.approx(4 / 14.0)


def test_ratio_is_of_pairs_with_their_spread() -> None:
    few = "1.000 (median of 3 pairs; single pairs 0.500 to 1.500)"
    assert throughput._ratio([2.0, 1.0, 3.0], [2.0, 2.0, 2.0]) == few
    many = "1.500 (median of 7 pairs, 95 % interval 0.500 to 3.500; single pairs 0.500 to 3.500)"
    assert throughput._ratio([1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0], [2.0] * 7) == many


def test_needs_of_a_night_follow_from_the_rates() -> None:
    lines = throughput._needs({1: 2.0, 2: 4.0}).splitlines()
    assert lines[3] == "| 1 | 2.00 | 8.3 min | 57,600 |"
    assert lines[-1] == "| 16 | 32.00 | 0.5 min | 921,600 |"


def test_folder_with_too_few_recordings_is_left_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="100 recordings expected, 0 found"):
        throughput._recordings(tmp_path, 100)
    assert not list(tmp_path.iterdir())

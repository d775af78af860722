"""The benchmark of a fleet of years, with few robots and nights."""

from pathlib import Path

import pytest

from benchmarks.fleet.years import main
from tests import running


@pytest.mark.slow
def test_one_more_night_is_timed_and_small_fleets_are_compared(tmp_path: Path) -> None:
    options = ("--robots", 3, "--nights", 30, "--own", 2, "--fleets", 1)
    lines = running.ran(main, tmp_path, *options).output.splitlines()
    assert lines[-1] == "1 of 1 small fleets have the alarms of their whole history"
    assert sum("of 3 robots, 31 nights" in line for line in lines) == 2

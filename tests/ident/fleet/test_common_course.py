"""A season that nobody measured is explained by what the other robots did."""

import numpy as np

from ident.fleet.series import Series
from recordings.recording import Floats
from tests.ident.fleet.conftest import events_of, rows_of, series_of

NIGHTS = 40
SEASON = 1 + 0.2 * np.clip((np.arange(NIGHTS) - 15) / 10, 0, 1)


def fleet(robots: int, extra: Floats | float = 1.0) -> list[Series]:
    rng = np.random.default_rng(0)
    values = [(1 + robot) * SEASON * (1 + rng.normal(0, 0.01, NIGHTS)) for robot in range(robots)]
    values[0] = values[0] * extra
    return series_of([row for i, value in enumerate(values) for row in rows_of(f"r{i}", {"c_v1": value})])[1]


def test_season_of_the_whole_fleet_is_no_event() -> None:
    assert len(events_of(fleet(3))) == 3  # too few robots to tell
    assert events_of(fleet(6)) == []


def test_robot_that_differs_from_the_fleet_is_one() -> None:
    extra = 1 + 0.2 * (np.arange(NIGHTS) >= 30)
    (event,) = events_of(fleet(6, extra))
    assert (event.robot, event.change.index) == ("r0", 30)

"""A season that nobody measured is explained by what the other robots did."""

from collections.abc import Callable

import numpy as np
import pyarrow as pa
import pytest

from ident.fleet.discoveries import events
from ident.fleet.recording_rows import Row
from ident.fleet.series import Series, nights_and_series
from recordings.recording import Floats

NIGHTS = 40
SEASON = 1 + 0.2 * np.clip((np.arange(NIGHTS) - 15) / 10, 0, 1)


@pytest.fixture
def fleet(rows: Callable[..., list[Row]], table: Callable[[list[Row]], pa.Table]) -> Callable[..., list[Series]]:
    def made(robots: int, extra: Floats | None = None, temperature: Floats | None = None) -> list[Series]:
        rng = np.random.default_rng(0)
        values = [(1 + robot) * SEASON * (1 + rng.normal(0, 0.01, NIGHTS)) for robot in range(robots)]
        if extra is not None:
            values[0] = values[0] * extra
        flat = [
            row for i, value in enumerate(values) for row in rows(f"r{i}", {"c_v1": value}, temperature=temperature)
        ]
        return nights_and_series(table(flat))[1]

    return made


def test_season_of_the_whole_fleet_is_no_event(fleet: Callable[..., list[Series]]) -> None:
    assert len(events(fleet(3))) == 3  # too few robots to tell
    assert events(fleet(6)) == []


def test_robot_that_differs_from_the_fleet_is_one(fleet: Callable[..., list[Series]]) -> None:
    extra = 1 + 0.2 * (np.arange(NIGHTS) >= 30)
    (event,) = events(fleet(6, extra))
    assert (event.nights.robot, event.change.index) == ("r0", 30)

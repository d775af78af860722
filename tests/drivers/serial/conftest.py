"""Serial lines without a machine behind them: a reply that does not come costs simulated time."""

import pytest

from drivers.serial import axis, drive, line
from tests.simulated_time import SimulatedTime, simulate_time


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> SimulatedTime:
    return simulate_time(monkeypatch, axis, drive, line)

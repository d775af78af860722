"""What both simulated rigs share: their loop and their clock."""

import threading

import pytest

from drivers.simulated import service, transports
from drivers.simulated.config import SimConfig
from recordings.buses import CanBus, SerialBus
from recordings.rig import Drive, Rig
from tests.patience import patient


@pytest.mark.parametrize("bus", [CanBus(channel="slow"), SerialBus()], ids=lambda bus: bus.transport)
def test_machine_slower_than_real_time_is_reported_once(
    bus: CanBus | SerialBus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, "LARGEST_LAG", -1.0)  # every lag is too large
    rig = Rig(name="slow", rate=20.0, bus=bus, drives=tuple(Drive(node_id=i) for i in (1, 2, 3)))
    warnings: list[str] = []
    warned = threading.Event()

    def warn(text: str) -> None:
        warnings.append(text)
        warned.set()

    simulated = transports.of(rig).serve(rig, SimConfig(), "realtime", 0)
    simulated.warn = warn
    with simulated:
        assert warned.wait(patient(60))
    assert len(warnings) == 1
    assert "slower than real time, so its time is delayed" in warnings[0]
    assert simulated.machine.time == 0.0

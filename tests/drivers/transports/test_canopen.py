import pytest

from drivers import transports
from drivers.transports import canopen
from drivers.transports.canopen import bus_load, check, highest_rate
from recordings.buses import CanBus
from recordings.errors import BadInput
from recordings.rig import simulated_rig


def test_transport_is_selected_by_the_rig() -> None:
    assert transports.of(simulated_rig()) is canopen


def test_bus_load_of_the_default_cycle() -> None:
    # SYNC 55 bit, 6 bytes 115 bit, 8 bytes 135 bit, at worst.
    assert bus_load(simulated_rig(), 500.0) == pytest.approx(805 * 500 / 1e6)


def test_rate_above_the_highest_is_refused_with_the_highest_rate() -> None:
    with pytest.raises(BadInput, match="choose --rate 994 or less"):
        check(simulated_rig().at_rate(2000.0))


def test_highest_rate_reaches_the_allowed_load() -> None:
    rig = simulated_rig()
    assert bus_load(rig, highest_rate(rig)) == pytest.approx(rig.can.max_load)


@pytest.mark.parametrize("rate", [250.0, 500.0])
def test_description_contains_load_and_rate(rate: float) -> None:
    text = canopen.describe(simulated_rig().at_rate(rate))
    assert f"{bus_load(simulated_rig(), rate):.0%} loaded" in text
    assert "highest rate 994 Hz" in text


def test_only_a_virtual_bus_is_simulated_here() -> None:
    rig = simulated_rig()
    assert canopen.simulated_here(rig)
    assert not canopen.simulated_here(rig.model_copy(update={"bus": CanBus(interface="socketcan", channel="can0")}))

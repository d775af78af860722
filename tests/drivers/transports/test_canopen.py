import pytest

from drivers import transports
from drivers.transports import canopen
from drivers.transports.canopen import bus_load, check, highest_rate
from recordings.buses import CanBus
from recordings.errors import BadInput
from recordings.rig import simulated_rig

RIG = simulated_rig()


def test_load_of_the_default_cycle_sets_the_highest_rate() -> None:
    # SYNC 55 bit, 6 bytes 115 bit, 8 bytes 135 bit, at worst.
    assert bus_load(RIG, 500.0) == pytest.approx(805 * 500 / 1e6)
    assert bus_load(RIG, highest_rate(RIG)) == pytest.approx(RIG.can.max_load)
    with pytest.raises(BadInput, match="choose --rate 994 or less"):
        check(RIG.at_rate(2000.0))


@pytest.mark.parametrize("rate", [250.0, 500.0])
def test_description_contains_load_and_rate(rate: float) -> None:
    text = canopen.describe(RIG.at_rate(rate))
    assert f"{bus_load(RIG, rate):.0%} loaded" in text
    assert "highest rate 994 Hz" in text


def test_transport_is_selected_by_the_rig_and_simulated_on_a_virtual_bus() -> None:
    assert transports.of(RIG) is canopen
    assert canopen.simulated_here(RIG)
    assert not canopen.simulated_here(RIG.model_copy(update={"bus": CanBus(interface="socketcan", channel="can0")}))

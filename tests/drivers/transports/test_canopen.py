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
    # A torque offset: 16 data bits of each drive and up to 4 stuffed ones.
    assert bus_load(RIG.with_torque_offset(), 500.0) == pytest.approx((805 + 3 * 20) * 500 / 1e6)
    assert bus_load(RIG, highest_rate(RIG)) == pytest.approx(RIG.can.max_load)
    text = canopen.describe(RIG.at_rate(500.0))
    assert text == "virtual 'delta', 1000 kbit/s, at worst 40% loaded; highest rate 994 Hz"
    with pytest.raises(BadInput, match="choose --rate 994 or less"):
        check(RIG.at_rate(2000.0))


def test_transport_is_selected_by_the_rig_and_simulated_on_a_virtual_bus() -> None:
    assert transports.of(RIG) is canopen
    assert canopen.simulated_here(RIG)
    assert not canopen.simulated_here(RIG.model_copy(update={"bus": CanBus(interface="socketcan", channel="can0")}))

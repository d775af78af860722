import os

import pytest

from drivers import transports
from drivers.transports import serial
from recordings.buses import SerialBus, SerialRegisters
from recordings.errors import BadInput
from recordings.rig import Drive, HomedBit, Rig


def rig(*ports: str, rate: float = 20.0, **bus: object) -> Rig:
    section = SerialBus(ports=ports or ("simulated",), **bus)
    drives = tuple(Drive(node_id=i, accept_missing=("watchdog",)) for i in (1, 2, 3))
    return Rig(name="r", rate=rate, bus=section, drives=drives)


# Longest commands and replies with joint limits of -32856 and 38332 counts, each with its end.
MOVE = len("1 s r0xca -32856.") + len("ok.") + len("1 t 1.") + len("ok.")
READ = len("1 g r0x32.") + len("v -32856.") + len("1 g r0x15.") + len("v -32768.")
LOOK = len("1 g r0xa0.") + len("v 4294967295.")
SWITCH_ON = len("1 s r0xca -32856.") + len("ok.") + len("1 s r0x24 21.") + len("ok.")


def wire_time(characters: int, exchanges: int = 0) -> float:
    return characters * 10 / 115_200 + exchanges * 0.001


def test_cycle_time_is_that_of_the_longest_commands_and_replies() -> None:
    of_three = 3 * (MOVE + READ) + LOOK + (SWITCH_ON - MOVE)
    assert serial.cycle_time(rig(turnaround=0.001)) == pytest.approx(wire_time(of_three, 3 * 4 + 1))
    quick = serial.cycle_time(rig(turnaround=0.0))
    assert quick == pytest.approx(wire_time(of_three))
    # Alone on a line, a drive needs no prefix.
    of_one = MOVE + READ + LOOK + (SWITCH_ON - MOVE) - 5 * len("1 ")
    assert serial.cycle_time(rig("a", "b", "c", turnaround=0.0)) == pytest.approx(wire_time(of_one))
    # In the longest cycle the drive whose status is read is enabled.
    without_update = serial.cycle_time(rig(turnaround=0.0, update=""))
    assert quick - without_update == pytest.approx(wire_time(2 * (len("1 t 1.") + len("ok."))))
    long_name = serial.cycle_time(rig(turnaround=0.0, registers=SerialRegisters(position="r0x0032")))
    assert long_name - quick == pytest.approx(wire_time(3 * 2))


def test_highest_rate_reaches_the_allowed_load_and_above_it_is_refused() -> None:
    slow, fast = (serial.highest_rate(rig(turnaround=0.0, baud=baud)) for baud in (115_200, 460_800))
    assert fast == pytest.approx(4 * slow)
    described = rig(max_load=0.5)
    assert serial.highest_rate(described) * serial.cycle_time(described) == pytest.approx(0.5)
    with pytest.raises(BadInput, match=r"at 100 Hz a cycle has 10\.0 ms.* choose --rate 31 or less"):
        serial.check(rig(rate=100.0))
    serial.check(rig(rate=31.0))


@pytest.mark.parametrize(
    "option",
    [{"mode": "interpolated"}, {"torque_actual": True}, {"homed": HomedBit(index=0x2F00)}, {"dcf": "drive.dcf"}],
)
def test_canopen_only_options_are_refused(option: dict[str, object]) -> None:
    plain = rig()
    drives = (*plain.drives[:2], plain.drives[2].model_copy(update=option))
    with pytest.raises(BadInput, match=f"'{next(iter(option))}' of joint 3 is for CANopen drives"):
        serial.check(plain.model_copy(update={"drives": drives}))


def test_description_contains_time_load_and_rate() -> None:
    assert serial.describe(rig(rate=25.0)) == (
        "serial, one line (simulated) at 115200 baud: a cycle takes up to 24.0 ms on the wire, 60% of the period, "
        "drives are read up to 14.0 ms apart; highest rate 31 Hz"
    )
    three = serial.describe(rig("/dev/a", "/dev/b", "/dev/c"))
    assert three.startswith("serial, 3 lines (/dev/a, /dev/b, /dev/c) at 115200 baud")
    assert "apart" not in three


def test_transport_is_selected_by_the_rig_and_simulated_where_its_ports_are() -> None:
    assert transports.of(rig()) is serial
    assert serial.simulated_here(rig("simulated1", "simulated2", "simulated3"))
    assert not serial.simulated_here(rig("/dev/ttyUSB0"))


def test_missing_port_is_named_and_the_others_are_released() -> None:
    controller, device = os.openpty()
    described = rig(os.ttyname(device), "/dev/no/such/port", "/dev/none")
    for _ in range(2):  # a port that is not released would be in use the second time
        with pytest.raises(BadInput, match=r"'/dev/no/such/port' cannot be opened.*bus\.ports"):
            serial.connect(described, lambda *line: None, lambda *frame: None, None)
    os.close(controller)
    os.close(device)

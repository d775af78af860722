"""Other programs disturb a run on vcan0: it ends with the correct reason and without power."""

from collections.abc import Callable
from pathlib import Path

import can
import pytest

from drivers.cia402 import DriveState
from recordings.reader import read
from tests.vcan.conftest import Bench, cansend, finished, going_first, states, wait_until_moving

pytestmark = pytest.mark.vcan

_WITHOUT_POWER = {DriveState.SWITCH_ON_DISABLED, DriveState.READY, DriveState.SWITCHED_ON, DriveState.FAULT}


def _emergency_of_node_2() -> None:
    """Error code 2310, register 01."""
    cansend("082#1023010000000000")


def _node_2_stopped_by_a_foreign_master() -> None:
    cansend("000#0202")


def _node_2_reset_by_a_foreign_master() -> None:
    cansend("000#8102")


def _rpdos_of_another_master() -> None:
    """Disable voltage after each of the recorder's RPDOs and before SYNC, which requires real-time priority."""
    order = can.Message(arbitration_id=0x202, data=bytes(6), is_extended_id=False)
    to_node_2 = [can.typechecking.CanFilter(can_id=0x202, can_mask=0x7FF)]
    with going_first(), can.Bus(interface="socketcan", channel="vcan0", can_filters=to_node_2) as bus:
        while bus.recv(2.0) is not None:
            bus.send(order)


def _bus_off() -> None:
    """Send the error frame of a CAN controller in bus-off; vcan has no controller."""
    with can.Bus(interface="socketcan", channel="vcan0") as bus:
        bus.send(can.Message(arbitration_id=0x040, is_error_frame=True, is_extended_id=False, data=bytes(8)))


DISTURBANCES: dict[Callable[[], None], str] = {
    _emergency_of_node_2: "joint 2 (node 2): EMCY 0x2310: continuous over-current",
    _node_2_stopped_by_a_foreign_master: "joint 2: no answer",
    _node_2_reset_by_a_foreign_master: "joint 2 (node 2): the drive restarted",
    _rpdos_of_another_master: "joint 2: the drive left operation by itself",
    _bus_off: "bus-off",
}


@pytest.mark.parametrize("disturb", DISTURBANCES, ids=lambda disturb: disturb.__name__[1:])
def test_disturbed_run_ends_with_its_reason_and_without_power(disturb: Callable[[], None], tmp_path: Path) -> None:
    bench = Bench(tmp_path, rate=100, answer_timeout=0.2)
    file = tmp_path / "disturbed.mcap"
    with bench.simulated_rig("lockstep"), bench.recording(file, "lockstep", "--cycles", "10") as process:
        wait_until_moving(process)
        disturb()
        done = finished(process)
        after = states()
    assert done.code == 1, done.err
    assert DISTURBANCES[disturb] in done.err
    assert set(after.values()) <= _WITHOUT_POWER, after
    recording = read(file)
    assert recording.run.exit_status == 1
    assert recording.run.reason is not None
    assert recording.run.reason in done.err

"""Foreign programs disturb a run on vcan0: it ends with the right reason and with drives without power."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import can
import pytest

from drivers.cia402 import State
from recordings.reader import read
from tests.vcan.conftest import Bench, cansend, finished, states, wait_until_moving

pytestmark = pytest.mark.vcan

_WITHOUT_POWER = {State.SWITCH_ON_DISABLED, State.READY, State.SWITCHED_ON, State.FAULT}


def _emergency_of_node_2() -> None:
    """Error code 2310, register 01."""
    cansend("082#1023010000000000")


def _node_2_stopped_by_a_foreign_master() -> None:
    cansend("000#0202")


def _node_2_reset_by_a_foreign_master() -> None:
    cansend("000#8102")


def _rpdos_of_another_master() -> None:
    """Disable voltage, again and again, until one comes between our own RPDO and SYNC."""
    subprocess.run(
        ["cangen", "vcan0", "-I", "202", "-L", "6", "-D", "000000000000", "-g", "0.3", "-n", "3000"], check=True
    )


def _bus_off() -> None:
    """The error frame that a controller's driver makes of it; vcan has no wire to cut."""
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
def test_a_disturbed_run_ends_with_its_reason_and_without_power(disturb: Callable[[], None], tmp_path: Path) -> None:
    bench = Bench(tmp_path, rate=100)
    file = tmp_path / "disturbed.mcap"
    with bench.simulated_rig("lockstep"), bench.recording(file, "lockstep", "--cycles", "5") as process:
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

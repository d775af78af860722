"""`daq rig lss` against the simulated bus: a node gets its id, alone or by its identity, from its next reset on."""

import contextlib
from collections.abc import Iterator

import can
import pytest

from drivers.simulated.config import SimConfig, SimDrive
from drivers.simulated.habits import Habits
from drivers.simulated.rig import SimulatedRig
from recordings.rig import Drive, Rig
from tests.conftest import Runner

RIG = Rig(name="test", drives=tuple(Drive(node_id=node) for node in (1, 2, 3)))


@contextlib.contextmanager
def served(channel: str) -> Iterator[can.BusABC]:
    """A bus with three simulated drives, whose serial numbers are 1, 2 and 3."""
    habits = (Habits(values={"1018:4": serial, "1018:1": 0xAB}) for serial in (1, 2, 3))
    config = SimConfig(drives=tuple(SimDrive(habits=each) for each in habits))
    bus = can.Bus(interface="virtual", channel=channel)
    machine = SimulatedRig(RIG, config, can.Bus(interface="virtual", channel=channel), pace="lockstep", seed=0)
    with contextlib.closing(machine), bus:
        machine.start()
        yield bus


def started(bus: can.BusABC, command: int) -> set[int]:
    """Node ids of the boot-up messages after an NMT command to all nodes."""
    while bus.recv(0):
        pass
    bus.send(can.Message(arbitration_id=0, data=[command, 0], is_extended_id=False))
    bus.send(can.Message(arbitration_id=0x603, data=bytes.fromhex("4000100000000000"), is_extended_id=False))
    found = set()
    # The third node keeps its id, and answers after all have started.
    while (message := bus.recv(10.0)) is not None and message.arbitration_id != 0x583:
        found.add(message.arbitration_id - 0x700)
    return found


@pytest.mark.parametrize("reset", [0x81, 0x82])
def test_a_node_gets_its_id_by_its_identity_and_from_the_next_reset_on(daq_in_process: Runner, reset: int) -> None:
    with served(f"lss {reset}") as bus:
        arguments = ("rig", "lss", "--bus", f"virtual:lss {reset}", "--node", 9)
        done = daq_in_process(*arguments, "--device", "0xAB,1,1,2", "--bitrate", 500_000)
        assert done.code == 0, done.err
        assert "node id 9 and 500000 bit/s stored" in done.out
        several = daq_in_process(*arguments)
        assert several.code == 1
        assert "several found" in several.err
        unknown = daq_in_process(*arguments, "--device", "0xAB,1,1,7")
        assert unknown.code == 1
        assert "no device with this identity" in unknown.err
        assert started(bus, 0x01) == set()
        assert started(bus, reset) == {1, 9, 3}

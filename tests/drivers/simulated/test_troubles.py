"""Troubles of simulated drives: what the bus sees of each; at which instant, and of which drives."""

from typing import get_args

import pytest

from drivers.cia402 import Controlword, DriveState, decode
from drivers.simulated.config import SimConfig
from drivers.simulated.drive_state_machine import PowerState
from drivers.simulated.habits import Trouble
from recordings.config import validated
from recordings.errors import BadInput
from tests.drivers.simulated.bench import NODE, PERIOD, Bench

LIMITED, FOLLOWS = 0x0800, 0x1000
TURN = 8192
"""Counts per turn of the motor."""


@pytest.fixture
def bench() -> Bench:
    """A drive that moves."""
    drive = Bench()
    drive.enable()
    drive.move(0.5)
    return drive


def answers(bench: Bench, cycles: int = 20) -> list[tuple[int, bytes]]:
    """What it sends while its master commands it to go on."""
    bench.sent.clear()
    bench.cycle(Controlword.ENABLE, bench.counts, cycles)
    return bench.sent


def test_each_has_a_name_in_the_sim_file(bench: Bench) -> None:
    assert {*get_args(Trouble)} == {*bench.drive.troubles.entries}


def test_at_a_limit_switch_it_stops_and_says_so(bench: Bench) -> None:
    bench.drive.troubles.begin("limit_switch")
    answers(bench)
    assert bench.state is PowerState.ENABLED
    assert bench.drive.statusword & (LIMITED | FOLLOWS) == LIMITED
    assert bench.drive.generator.at_rest


def test_a_statusword_that_flickers_is_wrong_once_in_ten(bench: Bench) -> None:
    bench.drive.troubles.begin("flicker")
    states = [decode(bench.drive.statusword) for _ in range(30)]
    assert states.count(DriveState.SWITCHED_ON) == 3
    assert states.count(DriveState.ENABLED) == 27


def test_a_lost_turn_moves_what_is_reported_of_a_joint_that_stands(bench: Bench) -> None:
    bench.held_at = before = bench.read(0x6064)
    bench.drive.troubles.begin("turn_lost")
    bench.sync()
    assert bench.read(0x6064) == before + TURN


@pytest.mark.parametrize(
    ("trouble", "state"),
    [("quick_stop", PowerState.QUICK_STOP), ("sync_loss", PowerState.FAULT_REACTION)],
)
def test_it_leaves_operation_by_itself(bench: Bench, trouble: Trouble, state: PowerState) -> None:
    bench.drive.troubles.begin(trouble)
    assert bench.state is state
    assert (0x080 + NODE in dict(bench.sent)) == (trouble == "sync_loss")


@pytest.mark.parametrize("trouble", ["quiet_reboot", "pre_operational", "bus_off"])
def test_it_sends_no_pdos_any_more_and_no_boot_up_message(bench: Bench, trouble: Trouble) -> None:
    bench.drive.troubles.begin(trouble)
    assert not any(cob_id & 0x780 == 0x180 or data == b"\0" for cob_id, data in answers(bench))


def test_a_drive_that_is_off_the_bus_hears_nothing(bench: Bench) -> None:
    bench.write(0x1016, "I", 127 << 16 | 100, sub=1)
    bench.drive.receive(0x77F, b"\x05", bench.now)
    bench.drive.troubles.begin("bus_off")
    for _ in range(100):
        bench.drive.receive(0x77F, b"\x05", bench.now)
        bench.run(PERIOD)
    assert not bench.drive.powered


def test_an_event_is_of_some_joints_and_begins_at_its_instant() -> None:
    event = {"at": 0.2, "trouble": "quick_stop", "joints": [2]}
    config = validated({"events": [event]}, SimConfig, "test")
    assert [config.troubles(joint) for joint in (1, 2, 3)] == [[], [(0.2, "quick_stop")], []]
    assert config.all_effects == ()
    bench = Bench(troubles=config.troubles(2))
    bench.enable()
    bench.run(0.2 - bench.now - PERIOD)
    assert bench.state is PowerState.ENABLED
    bench.run(2 * PERIOD)
    assert bench.state is not PowerState.ENABLED


@pytest.mark.parametrize("keys", [{}, {"trouble": "bus_off", "effect": {"name": "stribeck"}}])
def test_an_event_is_either_an_effect_or_a_trouble(keys: dict[str, object]) -> None:
    with pytest.raises(BadInput, match="either effect or trouble expected"):
        validated({"events": [{"at": 1.0, **keys}]}, SimConfig, "test")

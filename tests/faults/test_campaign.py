"""Part of the fault campaign; `make faults` runs all of it."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import pytest

from tests import timekeeping
from tests.failures import assert_safe
from tests.faults import campaign, canopen, feedforward, habits, power_up, processes, serial
from tests.faults.campaign import Outcome

_TESTED = (
    "one answer dropped",
    "answers dropped here and there",
    "all answers of a drive dropped",
    "all setpoints of a drive dropped",
    "cable pulled",
    "one position corrupted",
    "two drives with one node id",
    "drive fault in mid-motion",
    "drive heartbeat lost",
    "master heartbeat lost on the bus",
    "drive restarts in mid-motion",
    "second node of our id boots",
    "second node of our id, operational",
    "stray TPDO of our node",
    "bus-off",
    "bus-off that only the controller's state tells",
    "another master disables a drive",
    "another master stops a node (NMT)",
    "EMCY storm without fault",
    "joint blocked (collision)",
    "NMT stop by another master, heard",
    "answers dropped here and there, then a jam",
    "TPDO a byte short",
    "TPDO a byte long",
    "drive fault without EMCY",
    "foreign SYNC",
    "host stalls for 200 ms",
    "storm of warnings",
    "slow fault reset",
    "fault reset ignored until NMT reset communication",
    "drive left enabled by another program",
    "foreign PDOs from power-up",
    "unit of acceleration against the rig file",
    "drive fault in mid-motion, quick stop in rpm/s",
    "drive fault in mid-motion, others stay in quick stop",
    "polled voltage of 32 bits",
    "guarding requests lost on the bus",
    "answers to node guarding lost",
    "heartbeats beside node guarding",
)


_FED_FORWARD = (
    "feed-forward: all answers of a drive dropped",
    "feed-forward: drive fault in mid-motion",
    "feed-forward: host stalls for 200 ms",
    "model with gravity reversed, from 0, 0, -0.75 m",
    "model three times too strong, from -0.15, 0.2, -0.65 m",
    "soft servo, model with gravity reversed, from 0.1, -0.25, -0.7 m",
    "drive ignores its offset",
    "drive without torque offset",
)
_SERIAL = (
    "feed-forward, serial: one reply lost",
    "serial: model with gravity reversed",
    "serial: no watchdog",
    "serial: no watchdog, accepted",
)
_PROGRAMS = (
    "SIGINT twenty times",
    "SIGKILL of the recorder at full torque offset",
)


def _named(faults: Iterable[Any], names: Sequence[str]) -> list[Any]:
    found = {fault.name: fault for fault in faults}
    return [found[name] for name in names]


_CANOPEN = _named((*canopen.FAULTS, *habits.FAULTS), _TESTED)
_SIMULATED = [
    *((campaign.run, fault) for fault in _CANOPEN if fault.pace == "lockstep"),
    *((campaign.run, fault) for fault in _named((*feedforward.AGAIN, *feedforward.FAULTS), _FED_FORWARD)),
    *((serial.run, fault) for fault in _named((*serial.WITH_FEEDFORWARD, *serial.FAULTS), _SERIAL)),
]
_IN_REAL_TIME = [
    *((campaign.run, fault) for fault in _CANOPEN if fault.pace == "realtime"),
    *((power_up.run, fault) for fault in power_up.FAULTS),
    (serial.run, *_named(serial.FAULTS, ["serial: line unplugged"])),
    *((processes.run, fault) for fault in _named(processes.FAULTS, _PROGRAMS)),
]


_ESSENTIAL = (
    "drive fault in mid-motion",
    "model with gravity reversed, from 0, 0, -0.75 m",
    "storm of warnings",
    _SERIAL[0],
)
"""One of each kind: of the drives, of the torque that is fed forward, of the habits of drives, of serial lines."""


def _param(run: Callable[[Any], Outcome], fault: Any) -> Any:
    marks = [pytest.mark.essential] if fault.name in _ESSENTIAL else []
    return pytest.param(run, fault, id=fault.name, marks=marks)


@pytest.mark.slow
@pytest.mark.parametrize(("run", "fault"), [_param(*pair) for pair in _SIMULATED])
def test_fault_in_simulated_time(run: Callable[[Any], Outcome], fault: Any) -> None:
    outcome = run(fault)
    assert_safe(outcome.safe, outcome)
    assert outcome.passed, outcome


@pytest.mark.realtime
@pytest.mark.parametrize(("run", "fault"), [pytest.param(*pair, id=pair[1].name) for pair in _IN_REAL_TIME])
def test_fault_in_real_time(run: Callable[[Any], Outcome], fault: Any) -> None:
    with timekeeping.watched() as machine:
        outcome = run(fault)
    assert_safe(outcome.safe, outcome)
    machine.expect(outcome.passed, f"{outcome.fault}: {outcome.reason}")

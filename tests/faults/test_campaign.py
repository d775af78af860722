"""Part of the fault campaign; `make faults` runs all of it."""

import pytest

from tests import timekeeping
from tests.faults import campaign, canopen, feedforward, habits, processes, serial

_TESTED = (
    "one answer dropped",
    "all answers of a drive dropped",
    "all setpoints of a drive dropped",
    "cable pulled",
    "one position corrupted",
    "two drives with one node id",
    "drive fault in mid-motion",
    "drive heartbeat lost",
    "master heartbeat lost on the bus",
    "drive restarts in mid-motion",
    "bus-off",
    "joint blocked (collision)",
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
)


def test_campaign_has_at_least_forty_faults_with_unique_names() -> None:
    names = [fault.name for fault in (*canopen.FAULTS, *habits.FAULTS, *processes.FAULTS)]
    assert len(set(names)) == len(names) >= 40
    assert set(_TESTED) <= set(names)


def _tested_at(pace: str) -> list[campaign.Fault]:
    faults = (*canopen.FAULTS, *habits.FAULTS)
    return [fault for fault in faults if fault.name in _TESTED and fault.pace == pace]


@pytest.mark.slow
@pytest.mark.parametrize("fault", _tested_at("lockstep"), ids=lambda fault: fault.name)
def test_canopen_fault_in_lockstep(fault: campaign.Fault) -> None:
    outcome = campaign.run(fault)
    assert outcome.passed, outcome


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


@pytest.mark.slow
@pytest.mark.parametrize("name", _FED_FORWARD)
def test_fault_with_feedforward(name: str) -> None:
    (fault,) = (fault for fault in (*feedforward.AGAIN, *feedforward.FAULTS) if fault.name == name)
    outcome = campaign.run(fault)
    assert outcome.passed, outcome


@pytest.mark.slow
@pytest.mark.parametrize("name", ["feed-forward, serial: one reply lost", "serial: model with gravity reversed"])
def test_serial_fault_with_feedforward(name: str) -> None:
    (fault,) = (fault for fault in serial.WITH_FEEDFORWARD if fault.name == name)
    outcome = serial.run(fault)
    assert outcome.passed, outcome


@pytest.mark.realtime
@pytest.mark.parametrize("fault", _tested_at("realtime"), ids=lambda fault: fault.name)
def test_canopen_fault_in_real_time(fault: campaign.Fault) -> None:
    with timekeeping.watched() as machine:
        outcome = campaign.run(fault)
    assert outcome.safe, outcome
    machine.expect(outcome.passed, f"{outcome.fault}: {outcome.reason}")


@pytest.mark.realtime
@pytest.mark.parametrize(
    "fault",
    [
        f
        for f in processes.FAULTS
        if f.name in ("SIGINT twenty times", "SIGTERM") or f.name.startswith("SIGKILL of the rec")
    ],
    ids=lambda fault: fault.name,
)
def test_fault_of_a_program(fault: processes.ProcessFault) -> None:
    with timekeeping.watched() as machine:
        outcome = processes.run(fault)
    assert outcome.safe, outcome
    machine.expect(outcome.passed, f"{outcome.fault}: {outcome.reason}")

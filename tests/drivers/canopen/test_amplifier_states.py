"""With any commands and any lost or doubled frames, a stop ends without power and never enables a drive."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from daq.cycle.clock import LockstepClock
from daq.cycle.exchange import RunParts
from daq.cycle.progress import CycleProgress
from daq.cycle.recorder import NullRecorder
from daq.cycle.stopping import StopRequest
from daq.cycle.stream import Stream
from drivers.canopen.drive import CanopenDrives
from drivers.cia402 import Controlword
from drivers.protocol import Goal
from drivers.simulated.mark import EDS
from recordings.errors import RunFailed
from recordings.rig import Axis, Drive, Rig
from tests.drivers.canopen.lossy_bus import KINDS, LossyBus, kind_of
from tests.faults.habits import with_guarding

RIG = Rig(
    name="two axes",
    mechanism="axes",
    rate=200.0,
    axes=(Axis(), Axis()),
    drives=(Drive(node_id=1), Drive(node_id=2, mode="interpolated")),
)
DOWN = (Controlword.DISABLE_VOLTAGE, Controlword.QUICK_STOP)
"""Controlwords permitted during a stop."""
WATCHDOG = 1.0
"""Time in which a drive without a master comes to rest and switches power off [s]."""
HEARTBEATS = 2
"""Number of heartbeats that may be lost in one run."""
DEAF, MUTE = ("nmt", "request", "rpdo"), ("response", "tpdo")
"""Kinds of frames that a drive does not receive (apart from SYNC and heartbeat), or cannot send."""
DISTURBED = st.sampled_from([DEAF, MUTE, ("sync",), ("rpdo",)]) | st.sampled_from(KINDS).map(lambda kind: (kind,))
COUNTS = st.sampled_from([1, 3, 1000])


def controlword(arbitration_id: int, data: bytes) -> int | None:
    """The controlword that a frame of the master carries."""
    if kind_of(arbitration_id) == "rpdo":
        return int.from_bytes(data[:2], "little")
    if kind_of(arbitration_id) == "request" and data[:4] == bytes.fromhex("2b406000"):
        return int.from_bytes(data[4:6], "little")
    return None


class AnyRun(RuleBasedStateMachine):
    """The real driver and the real end of a run; `bus.drives` have the true states."""

    rig, eds = RIG, EDS

    @initialize(cycles=st.sampled_from([0, 2, 5]))
    def begin(self, cycles: int) -> None:
        self.bus = LossyBus(self.rig, self.eds)
        self.bus.witness = self.judge
        self.driver: CanopenDrives | None = None
        self.connect(repaired=True)
        self.stream(cycles, None)

    def judge(self, arbitration_id: int, data: bytes) -> None:
        word = controlword(arbitration_id, data)
        if self.stopping and word is not None:
            assert word in DOWN, f"controlword 0x{word:04X} while stopping"

    # Actions of the program

    @precondition(lambda self: self.driver is None)
    @rule(repaired=st.booleans())
    def connect(self, repaired: bool) -> None:
        if repaired:
            self.bus.pulled = False
            self.bus.losses.clear()
        self.stopping = False
        self.heartbeats = HEARTBEATS
        self.driver = self.bus.driver()
        try:
            self.driver.discover()
            self.driver.configure()
        except RunFailed:
            self.leave(confirmed=False)

    @precondition(lambda self: self.driver is not None and not self.stopping)
    @rule(cycles=st.sampled_from([1, 3, 5, 15]), step=st.integers(-300, 300) | st.none())
    def stream(self, cycles: int, step: int | None) -> None:
        """Enable and follow targets: all actions before a stop."""
        assert self.driver is not None
        self.driver.goal = Goal.ENABLED
        for _ in range(cycles):
            target = None
            if step is not None:
                here = [drive.generator.position for drive in self.bus.drives]
                (target,) = self.driver.encode(np.array([here]) + step * 1e-5)
            self.driver.exchange(target, 0.01)

    @precondition(lambda self: self.driver is not None)
    @rule(goal=st.sampled_from([Goal.STOPPED, Goal.DISABLED]), cycles=st.integers(0, 3))
    def begin_to_stop(self, goal: Goal, cycles: int) -> None:
        assert self.driver is not None
        self.driver.goal = goal
        self.stopping = True
        for _ in range(cycles):
            self.driver.exchange(None, 0.01)

    @precondition(lambda self: self.driver is not None)
    @rule(cycles=st.sampled_from([0, 5]), kinds=st.just(()) | DISTURBED, count=COUNTS, doubled=st.booleans())
    def stop(self, cycles: int, kinds: tuple[str, ...], count: int, doubled: bool) -> None:
        """The end of every run, as in `daq record`, often during the motion and on a disturbed bus."""
        assert self.driver is not None
        if not self.stopping:
            self.stream(cycles, None)
        self.disturb(kinds, count, doubled)
        self.stopping = True
        clock = LockstepClock(self.rig.rate)
        parts = RunParts(self.rig, self.driver, clock, NullRecorder(), StopRequest(), CycleProgress())
        left_on = Stream(parts)._disable()
        for joint in self.bus.enabled:
            assert f"joint {joint}" in left_on, f"joint {joint} is enabled; reported as left on: {left_on!r}"
        self.leave(confirmed=not left_on)

    def leave(self, *, confirmed: bool) -> None:
        assert self.driver is not None
        self.stopping = True
        self.driver.close()
        self.driver = None
        if not confirmed:
            self.bus.wait(WATCHDOG)
        assert not self.bus.enabled, f"joints {self.bus.enabled} are enabled without a master"

    # Disturbances: few rules, so that most sequences reach many states

    @rule(kinds=DISTURBED, count=COUNTS, doubled=st.booleans())
    def disturb(self, kinds: tuple[str, ...], count: int, doubled: bool) -> None:
        for kind in kinds:
            self._disturb(kind, count, doubled)

    def _disturb(self, kind: str, count: int, doubled: bool) -> None:
        # A heartbeat arms the watchdog: a drive that receives targets but no heartbeat of a run cannot detect the
        # loss of its master.
        if kind == "heartbeat" and not doubled:
            count = min(count, self.heartbeats)
            self.heartbeats -= count
        (self.bus.doubles if doubled else self.bus.losses)[kind] += count

    @rule(pulled=st.booleans(), duration=st.sampled_from([0.0, 0.01, 0.3]))
    def cable(self, pulled: bool, duration: float) -> None:
        """Pull or connect the cable; then the host pauses."""
        self.bus.pulled = pulled
        self.bus.wait(duration)

    @rule(number=st.sampled_from([0, 1]), command=st.sampled_from([None, 0x02, 0x80, 0x81]))
    def drive(self, number: int, command: int | None) -> None:
        """A fault; or an NMT command of another master (stop, pre-operational, reset)."""
        drive = self.bus.drives[number]
        if command is None:
            drive.fail(0x4310)
        else:
            drive.receive(0x000, bytes([command, 0]), self.bus.now)

    @invariant()
    def nobody_is_enabled_without_a_master(self) -> None:
        assert self.driver is not None or not self.bus.enabled


class AnyRunOfGuardedDrives(AnyRun):
    """Drives with node guarding; one of them stays in quick stop until it is switched off."""

    rig = RIG.model_copy(update={"drives": (Drive(node_id=1), Drive(node_id=2, quick_stop_option=6))})

    def __init__(self) -> None:
        super().__init__()
        self._folder = tempfile.TemporaryDirectory()
        self.eds = Path(self._folder.name) / "guarded.eds"
        self.eds.write_text(with_guarding(EDS.read_text()))

    def teardown(self) -> None:
        self._folder.cleanup()


@pytest.mark.parametrize(
    ("machine", "examples"),
    [
        (AnyRun, 75),
        (AnyRunOfGuardedDrives, 30),
        pytest.param(AnyRun, 300, marks=pytest.mark.slow),
        pytest.param(AnyRunOfGuardedDrives, 60, marks=pytest.mark.slow),
    ],
)
def test_any_run(machine: type[AnyRun], examples: int) -> None:
    chosen = settings(max_examples=examples, stateful_step_count=15, deadline=None, derandomize=True)
    run_state_machine_as_test(machine, settings=chosen)


def test_watchdog_is_armed_when_the_first_heartbeats_are_lost() -> None:
    """The first heartbeat would have armed the watchdog."""
    run = AnyRun()
    run.begin(0)
    run.disturb(("heartbeat",), HEARTBEATS, doubled=False)
    run.stream(4, None)
    assert run.bus.enabled == [1, 2]
    run.cable(pulled=True, duration=0.0)
    run.stop(0, (), 1, doubled=False)


def test_drive_that_receives_no_commands_is_reported_as_left_on() -> None:
    run = AnyRun()
    run.begin(5)
    run.stop(5, DEAF, 1000, doubled=False)


def test_drive_whose_answers_are_lost_does_not_count_as_switched_off() -> None:
    """The last answer came before the drive was enabled."""
    run = AnyRun()
    run.begin(2)
    run.disturb(MUTE, 1000, doubled=False)
    run.stream(3, None)
    assert run.bus.enabled == [1, 2]
    run.stop(0, DEAF, 1000, doubled=False)

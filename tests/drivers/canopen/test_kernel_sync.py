"""Period of the kernel's SYNC with an imitated kernel; tests/vcan uses the real one."""

import socket
import time
from collections import deque
from functools import partial
from itertools import pairwise
from pathlib import Path
from unittest.mock import MagicMock

import can
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.bus import Link
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.kernel_sync import KernelSync, Pacer
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis, CanBus, Drive, Rig, Torque, load_rig
from tests.drivers.canopen.lossy_bus import LossyBus
from tests.drivers.canopen.scripted import ScriptedBus

PERIOD = 0.002


def _paced(delays: list[float]) -> tuple[list[int], Floats]:
    """Numbers and lateness [s] of SYNCs from a kernel that sends each one later than due by its delay [s].

    As in the kernel, the period counts from the time at which the previous frame was sent, and a new period takes
    effect from the SYNC after the next.
    """
    pacer = Pacer(PERIOD, first=10.0)
    now, period, following = 10.0, PERIOD, PERIOD
    numbers, late = [], []
    for delay in delays:
        now += delay
        number, following = pacer.on_sync(now)
        numbers.append(number)
        late.append(now - (10.0 + number * PERIOD))
        now += period
        period = round(following, 6)
    return numbers, np.array(late)


@given(st.floats(0, 5e-5), st.integers(0, 2**32 - 1))
def test_period_is_kept_by_a_kernel_with_a_constant_delay(delay: float, seed: int) -> None:
    jitter = np.random.default_rng(seed).exponential(1e-6, 3000)
    numbers, late = _paced((delay + jitter).tolist())
    assert numbers == list(range(3000))
    assert abs(late[500:].mean()) < 1e-6
    assert np.abs(late[500:]).max() < 3e-5


@given(st.floats(1e-4, 0.049))
def test_syncs_after_a_stall_are_numbered_by_time(stall: float) -> None:
    numbers, late = _paced([0.0] * 50 + [stall] + [0.0] * 200)
    assert all(later > earlier for earlier, later in pairwise(numbers))
    assert abs(numbers[50] - (50 + stall / PERIOD)) < 0.5 + 1e-6
    assert np.abs(late).max() <= PERIOD / 2 + 1e-9
    assert abs(late[-1]) < 1e-4


class KernelBus(LossyBus):
    """A bus on which the kernel sends SYNC, also while the host is late."""

    def __init__(self, rig: Rig) -> None:
        super().__init__(rig)
        self._stamps = deque[float]()
        self._due = time.time()

    def send_sync(self) -> None:
        """The kernel sends a SYNC, and the drives answer."""
        self._inbox.append((0x080, b""))
        self._stamps.append(self._due)
        self._due += self._period
        self.to_drives(0x080, b"")
        self.wait(self._period)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        # A host that waits receives the next SYNC.
        if not self._inbox and timeout:
            self.send_sync()
        message = super().recv(timeout)
        if message is not None and message.arbitration_id == 0x080:
            message.is_rx, message.timestamp = False, self._stamps.popleft()
        return message


@pytest.fixture
def kernel_drives(monkeypatch: pytest.MonkeyPatch) -> tuple[CanopenDrives, KernelBus]:
    """Two drives that have answered each SYNC of an imitated kernel for some time."""
    monkeypatch.setattr(socket, "socket", MagicMock())
    rig = Rig(
        name="two axes",
        rate=1 / PERIOD,
        bus=CanBus(interface="socketcan", sync="kernel"),
        mechanism="axes",
        axes=(Axis(), Axis()),
        drives=(Drive(node_id=1), Drive(node_id=2)),
        torque=Torque(gain=(1.0, 1.0)),
    )
    bus = KernelBus(rig)
    bus.recv = partial(LossyBus.recv, bus)  # type: ignore[method-assign]
    link = Link(bus)
    link.clock, link._marks_own = bus.now_ns, False
    drives = CanopenDrives(rig, link, lambda *line: None, KernelSync(link, "can0", PERIOD))
    drives.discover()
    drives.configure()
    del bus.recv
    for _ in range(100):
        assert drives.exchange(None, 0.1).missing == 0
    return drives, bus


@pytest.mark.parametrize("skipped", [1, 7])
def test_answers_to_syncs_that_the_host_missed_are_those_of_the_drives(
    kernel_drives: tuple[CanopenDrives, KernelBus], skipped: int
) -> None:
    drives, bus = kernel_drives
    for _ in range(20):
        before = drives.exchange(None, 0.1).sync
        for volts in range(skipped):
            bus.volts = 0.1 * volts
            bus.send_sync()
        sample = drives.exchange(None, 0.1)
        assert (sample.trouble, sample.missing) == (None, 0)
        assert before is not None
        assert sample.sync == before + skipped + 1


def test_a_second_node_is_found_beside_the_sync_of_the_kernel(kernel_drives: tuple[CanopenDrives, KernelBus]) -> None:
    drives, bus = kernel_drives
    bus.send_sync()
    bus._answer(0x182, bytes.fromhex("27 06 FF FF FF 7F 00 00"))
    assert str(drives.exchange(None, 0.1).trouble).startswith("a second TPDO of joint 2 (node 2)")


def test_missing_interface_is_bad_input() -> None:
    with pytest.raises(BadInput, match=r"bus\.sync"):
        KernelSync(Link(ScriptedBus([])), "nocan7", PERIOD)


def test_kernel_sync_requires_socketcan(tmp_path: Path) -> None:
    drives = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
    file = tmp_path / "rig.toml"
    file.write_text(f'name = "bench"\n[bus]\nsync = "kernel"\n{drives}')
    with pytest.raises(BadInput, match="socketcan"):
        load_rig(file)

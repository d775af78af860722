"""Period of the kernel's SYNC with an imitated kernel; tests/vcan uses the real one."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.bus import Link
from drivers.canopen.kernel_sync import KernelSync, Pacer
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import load_rig
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


def test_missing_interface_is_bad_input() -> None:
    with pytest.raises(BadInput, match=r"bus\.sync"):
        KernelSync(Link(ScriptedBus([])), "nocan7", PERIOD)


def test_kernel_sync_requires_socketcan(tmp_path: Path) -> None:
    drives = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
    file = tmp_path / "rig.toml"
    file.write_text(f'name = "bench"\n[bus]\nsync = "kernel"\n{drives}')
    with pytest.raises(BadInput, match="socketcan"):
        load_rig(file)

"""Compare the timing of the recorder's cycle with a plain loop on the PDO variables of the canopen library.

`python -m benchmarks.cycle [SECONDS]` runs both against `daq sim` in another process, with drives without power. Then
it searches for the highest rate that the recorder's cycle keeps without a missed cycle.
"""

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import canopen
import numpy as np
from numpy.typing import NDArray

from benchmarks.programs import DRIVES, claim
from daq.cycle.clock import HostClock
from daq.cycle.stream import _quiet_interpreter
from drivers import transports
from drivers.protocol import Amplifiers
from drivers.simulated.mark import EDS
from recordings.rig import Rig, load_rig
from tests.running import free_port, served

_RIG = f"""
name = "bench"
rate = {{rate}}
[bus]
interface = "udp_multicast"
channel = "239.74.163.2"
port = {{port}}
max_load = 1.0
bitrate = 10000000
{DRIVES}"""


@dataclass(frozen=True)
class CycleTiming:
    """Result of a run: lateness of each cycle [s], number of missed cycles and of lost answers."""

    lateness: NDArray[np.float64]
    missed: int
    lost: int

    def __str__(self) -> str:
        p50, p99, worst = (1e3 * float(np.quantile(self.lateness, q)) for q in (0.5, 0.99, 1.0))
        return (
            f"lateness p50 {p50:.3f} ms, p99 {p99:.3f} ms, worst {worst:.2f} ms; "
            f"{len(self.lateness)} cycles, {self.missed} missed, {self.lost} answers lost"
        )


@contextmanager
def simulated(rate: float) -> Iterator[Rig]:
    """Run `daq sim` in another process."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.toml"
        path.write_text(_RIG.format(rate=rate, port=free_port()))
        with served(Path(folder), "--rig", path):
            yield load_rig(path)


def ours(rate: float, seconds: float) -> CycleTiming:
    """Run the driver and the clock of `daq record`."""
    with simulated(rate) as rig:
        drives = transports.of(rig).connect(rig, lambda *line: None, lambda *frame: None, None)
        try:
            return _cycles(drives, rate, seconds)
        finally:
            drives.close()


def _cycles(drives: Amplifiers, rate: float, seconds: float) -> CycleTiming:
    drives.discover()
    drives.configure()
    clock = HostClock(rate)
    lateness, lost, index, missed = [], 0, 0, 0
    with _quiet_interpreter():
        while index < seconds * rate:
            skipped = int(clock.overdue(index) * rate)
            index, missed = index + skipped, missed + skipped
            late = clock.wait(index)
            lost += drives.exchange(None, max(clock.answer_timeout - late, 0.2 * clock.answer_timeout)).missing
            lateness.append(late)
            index += 1
    return CycleTiming(np.array(lateness), missed, lost)


def plain(rate: float, seconds: float) -> CycleTiming:
    """Run the loop of the library's documentation: its SYNC producer, PDO variables, a wait for each answer."""
    with simulated(rate) as rig:
        network = canopen.Network()
        bus = rig.can
        network.connect(interface=bus.interface, channel=bus.channel, port=bus.port, fd=False)
        nodes = [network.add_node(drive.node_id, str(EDS)) for drive in rig.drives]
        for node in nodes:
            node.nmt.state = "PRE-OPERATIONAL"
            node.tpdo.read()
            node.rpdo.read()
            node.nmt.state = "OPERATIONAL"
        period = 1 / rate
        network.sync.start(period)
        lateness, lost = [], 0
        nodes[0].tpdo[1].wait_for_reception(1.0)
        start = before = time.perf_counter()
        index = 0
        while time.perf_counter() - start < seconds:
            for node in nodes:
                if node.tpdo[1].wait_for_reception(period) is None:
                    lost += 1
                position = node.tpdo[1][1].raw
                node.rpdo[1][0].raw = 0
                node.rpdo[1][1].raw = position
                node.rpdo[1].transmit()
            index += 1
            # SYNC is sent by another thread, so the lateness is the excess of the loop time over the period.
            now = time.perf_counter()
            lateness.append(max(0.0, now - before - period))
            before = now
        network.sync.stop()
        network.disconnect()
        return CycleTiming(np.array(lateness), max(0, round(seconds * rate) - index), lost)


def main(seconds: float = 60.0) -> None:
    """Print the comparison, and the highest rate without a missed cycle."""
    print(f"500 Hz, three drives, {seconds:g} s, two processes on udp_multicast")
    recorder_run, plain_run = ours(500.0, seconds), plain(500.0, seconds)
    print(f"  daq record's cycle: {recorder_run}")
    print(f"  plain canopen loop: {plain_run}")
    ratio = np.quantile(plain_run.lateness, 0.99) / np.quantile(recorder_run.lateness, 0.99)
    print(f"  p99 of the lateness, plain over ours: {ratio:.1f}")
    highest = 0.0
    for rate in (200.0, 500.0, 1000.0, 2000.0, 4000.0):
        run = ours(rate, seconds / 6)
        print(f"  {rate:g} Hz: {run}")
        if run.missed == 0:
            highest = rate
    print(f"  highest rate without a missed cycle: {highest:g} Hz")
    claim("500 Hz without a missed cycle, and less late than a plain loop", bool(highest >= 500 and ratio > 1))


if __name__ == "__main__":
    main(*(float(argument) for argument in sys.argv[1:2]))

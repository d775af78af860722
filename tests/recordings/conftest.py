"""A small recording with messages of all topics, and the arrays written to it."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from recordings.recording import Run
from recordings.rig import Rig, simulated_rig
from recordings.writer import RecordingWriter
from tests.made_up import run_of

PERIOD_NS = 2_000_000
START_NS = 1_700_000_000_000_000_000


@pytest.fixture(scope="session")
def rig() -> Rig:
    return simulated_rig()


@pytest.fixture(scope="session")
def run() -> Run:
    return run_of(period=0.5, seed=7)


class Samples(SimpleNamespace):
    def __repr__(self) -> str:
        return f"Samples(n={self.n})"  # not pages of numbers in a failing test's report


def make_samples(n: int) -> Samples:
    rng = np.random.default_rng(3)
    position = rng.normal(size=(n, 3))
    position[5, 1] = np.nan
    return Samples(
        n=n,
        stamp=START_NS + PERIOD_NS * np.arange(n),
        position=position,
        command=rng.normal(size=(n, 3)),
        effort=rng.normal(size=(n, 3)),
        voltage=rng.normal(size=(n, 3)),
        statusword=rng.integers(0, 2**16, size=(n, 3)),
        error_code=rng.integers(0, 2**16, size=(n, 3)),
        repeat=np.repeat((-1, 0, 1), n // 3),
        lateness=rng.uniform(0, 1e-3, size=n),
    )


def write_samples(path: Path, rig: Rig, run: Run, samples: Samples) -> None:
    with RecordingWriter(path, rig, run) as writer:
        writer.event(START_NS - 10**9, "info", "drives", "enabled")
        for k, stamp in enumerate(samples.stamp.tolist()):
            log = stamp + 700_000
            writer.can(stamp, stamp, 0x80, b"", sent=True)
            writer.can(stamp, log, 0x181, bytes([k % 256, 2, 3]), sent=False)
            writer.joint_states(stamp, log, samples.position[k], effort=samples.effort[k])
            writer.joint_commands(stamp, log, samples.command[k])
            writer.amplifiers(
                stamp,
                log,
                k,
                samples.repeat[k],
                samples.lateness[k],
                samples.voltage[k],
                samples.statusword[k],
                samples.error_code[k],
            )
            writer.platform_reference(stamp, log, (0.1, 0.2, -0.8))
        writer.event(log, "warning", "cycle", "Überlänge: missed 1")
        writer.event(log, "error", "cycles", "bus: missed 2")
        writer.close(0, "trajectory done")


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory, rig: Rig, run: Run) -> Samples:
    """`path` of a recording of 600 SYNCs (three chunks and the events) and the arrays written to it."""
    samples = make_samples(600)
    samples.path = tmp_path_factory.mktemp("recordings") / "made.mcap"
    write_samples(samples.path, rig, run, samples)
    return samples

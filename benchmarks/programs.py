"""The installed programs as benchmarks run them, and what they measure with: recordings, ratios of pairs."""

import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from scipy import stats

SEED = 9
"""Seed of the hidden effect of `make demo`."""
DRIVES = "".join(f"[[drives]]\nnode_id = {number}\n" for number in (1, 2, 3))
"""Three drives of a rig file."""


def program(name: str) -> str:
    """Path of the installed command `name`."""
    return str(Path(sys.executable).with_name(name))


def call(name: str, *arguments: object) -> str:
    """Run the command `name`; return what it prints, or end with what it says of its failure."""
    done = subprocess.run([program(name), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{name} {' '.join(map(str, arguments))}\n{done.stderr}")
    return done.stdout


def record(out: Path, trajectory: object, *options: object) -> Path:
    """Record a `trajectory` on the simulated rig into the file `out`."""
    call("daq", "record", "--traj", trajectory, *options, "--out", out)
    return out


def record_demo(folder: Path, *trajectories: str, rate: float = 500.0) -> list[Path]:
    """Record each of `trajectories` at `rate` [Hz] into `folder`, with the hidden effect of `make demo`."""
    folder.mkdir(exist_ok=True)
    return [record(folder / f"{name}.mcap", name, "--rate", rate, "--hidden", SEED) for name in trajectories]


def ratio(values: Sequence[float], others: Sequence[float]) -> str:
    """Median ratio over the pairs, with its 95 % interval by order statistics, and the extremes, as text."""
    ratios = sorted(value / other for value, other in zip(values, others, strict=True))
    rank = int(stats.binom.ppf(0.025, len(ratios), 0.5))
    interval = f", 95 % interval {ratios[rank - 1]:.3f} to {ratios[-rank]:.3f}" if rank else ""
    pairs = f"median of {len(ratios)} pairs{interval}; single pairs {ratios[0]:.3f} to {ratios[-1]:.3f}"
    return f"{statistics.median(ratios):.3f} ({pairs})"


def claim(what: str, reached: bool) -> None:
    """Print as the last line of a benchmark what it is about, and whether that is so."""
    print(f"{what}: {'so it is' if reached else 'FALLS SHORT'}", flush=True)

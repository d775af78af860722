"""The installed programs as benchmarks run them, and the recordings that they make."""

import subprocess
import sys
from pathlib import Path

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


def record_demo(folder: Path, trajectory: str) -> Path:
    """Record a `trajectory` into `folder`, with the hidden effect of `make demo`."""
    return record(folder / f"{trajectory}.mcap", trajectory, "--hidden", SEED)


def claim(what: str, reached: bool) -> None:
    """Print as the last line of a benchmark what it is about, and whether that is so."""
    print(f"{what}: {'so it is' if reached else 'FALLS SHORT'}", flush=True)

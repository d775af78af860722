"""Recordings of `make demo`, created within a few seconds."""

import subprocess
import sys
from pathlib import Path

SEED = 9
"""Seed of the hidden effect."""


def record(folder: Path, *trajectories: str, rate: float = 500.0) -> list[Path]:
    """Record each of `trajectories` on the simulated rig at `rate` [Hz] into `folder`."""
    folder.mkdir(exist_ok=True)
    paths = [folder / f"{name}.mcap" for name in trajectories]
    for name, path in zip(trajectories, paths, strict=True):
        command = [program("daq"), "record", "--traj", name, "--rate", str(rate), "--hidden", str(SEED)]
        subprocess.run([*command, "--out", str(path)], check=True, capture_output=True)
    return paths


def program(name: str) -> str:
    """Path of the installed command `name`."""
    return str(Path(sys.executable).with_name(name))

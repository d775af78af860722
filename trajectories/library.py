"""Available trajectories: built-in ones, one file each in `trajectories/paths`, and the user's files."""

import importlib
import pkgutil
from pathlib import Path

from recordings.errors import BadInput, did_you_mean
from recordings.rig import Rig
from trajectories import paths
from trajectories.motion import PlannedMotion
from trajectories.trajectory import Trajectory, assemble


def names() -> tuple[str, ...]:
    """Names of the built-in trajectories, in alphabetical order."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(paths.__path__)))


def load(name_or_path: str | Path, rig: Rig, cycles: int | None = None, rate: float | None = None) -> Trajectory:
    """Load the trajectory of that name or file for `rig`; `cycles` and `rate` as in `assemble`.

    Limits are not checked here, see `trajectories.checks.check`.

    Raises:
        BadInput: the trajectory is unknown, its file is invalid, or cycles or rate are invalid.
        Unreachable: the robot cannot reach a position; the error names the first instant.
    """
    return assemble(_motion(str(name_or_path)), rig, cycles, rate)


def _motion(name_or_path: str) -> PlannedMotion:
    if name_or_path in names():
        motion = importlib.import_module(f"{paths.__name__}.{name_or_path}").motion()
        assert isinstance(motion, PlannedMotion)
        return motion
    path = Path(name_or_path)
    if path.suffix.lower() not in (".csv", ".toml"):
        raise BadInput(
            f"unknown trajectory '{name_or_path}';{did_you_mean(str(name_or_path), names())} expected "
            f"{', '.join(names())}, or the path of a .csv or .toml file"
        )
    from trajectories.files import read_motion

    return read_motion(path)

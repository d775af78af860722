"""The trajectories there are: one file each in `trajectories/paths`, and files of the user's."""

import importlib
import pkgutil
from pathlib import Path

from recordings.errors import BadInput
from recordings.rig import Rig
from trajectories import paths
from trajectories.motion import PlannedMotion
from trajectories.trajectory import Trajectory, assemble


def names() -> tuple[str, ...]:
    """The built-in trajectories, in alphabetical order."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(paths.__path__)))


def load(name_or_path: str | Path, rig: Rig, cycles: int | None = None, rate: float | None = None) -> Trajectory:
    """The trajectory of that name, or from that file, for `rig`; `cycles` and `rate` as in `assemble`.

    Limits are not checked here: see `trajectories.checks.check`.

    Raises:
        BadInput: no such trajectory, a file that is not one, cycles or rate that do not fit.
        Unreachable: the robot cannot get there, naming the first instant.
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
            f"unknown trajectory '{name_or_path}'; expected {', '.join(names())}, or the path of a .csv or .toml file"
        )
    from trajectories.files import read_motion

    return read_motion(path)

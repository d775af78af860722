"""The commands that are printed as what comes next: none fails because an output exists."""

import re
import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from recordings.command_line import repeated
from recordings.files import free_name

OWN_RIG = "RIG.toml stands for the rig file of your robot"
"""Note behind a command that records with a robot whose rig file is not known."""

NEXT_MOTION = Path("next.toml")
"""Trajectory file of a motion that is designed to be recorded next."""


def better_name(model: Path) -> Path:
    """A name beside the file `model` for the model that a diagnosis makes of it; no such file exists."""
    stem = re.sub(r"(\.better(-\d+)?)?(\.model)?(\.json)?$", "", model.name)
    return free_name(model.with_name(f"{stem}.better.model.json"))


def diagnosis(files: Sequence[Path], *options: object, model: Path | None = None) -> list[object]:
    """Words of `ident diagnose` with the recordings `files`.

    model: the model that is to be improved, or the file that is written by default; None: no model is written.
    """
    apply: list[object] = ["--apply"] if model else []
    if model and model.exists():
        apply += ["-o", better_name(model)]
    return ["ident", "diagnose", *files, *options, *apply]


def design(recordings: Iterable[Path], *options: object) -> str:
    """The command that designs the motion to record next on the rig of the `recordings`."""
    files = repeated("--recording", dict.fromkeys(recordings))
    return shlex.join(["ident", "design", *map(str, options), *files, "-o", str(free_name(NEXT_MOTION))])

"""Data problems that need no model: what cannot be right about a recording.

One kind is one module of `kinds`, found by its name. It has a function `find(recording)` that returns the problem, or
None. Those that take a model live in `ident.data_problems`.
"""

import importlib
import pkgutil
import shlex
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from recordings.config import ConfigSection
from recordings.data_problems import kinds
from recordings.files import free_name
from recordings.recording import Recording


class DataProblem(ConfigSection):
    """One problem, as all documents list it."""

    kind: str
    joints: tuple[int, ...]
    """From 1; empty for all."""
    blocks: bool
    """Whether the program cannot take it out itself."""
    why: str
    remedy: str
    """A command that heals the file, or a sentence that says what to record."""

    @property
    def command(self) -> list[str] | None:
        """Words of the remedy, if it is a command."""
        return shlex.split(self.remedy) if self.remedy.startswith("daq ") else None


def healing(problems: Iterable[DataProblem]) -> list[str] | None:
    """Words of the first command that heals what blocks; None where something else is to be recorded."""
    return next((each.command for each in problems if each.blocks and each.command), None)


def problems(recording: Recording) -> Iterator[DataProblem]:
    """Yield the problems of a `recording`, by kind in alphabetical order."""
    for module in pkgutil.iter_modules(kinds.__path__):
        found = importlib.import_module(f"{kinds.__name__}.{module.name}").find(recording)
        if found is not None:
            yield found


def healing_command(path: Path, options: Sequence[str]) -> str:
    """The command that writes the recording `path` anew with these `options` of `daq import`, under a free name.

    Of a recording in memory, which has no suffix, a sentence.
    """
    if not path.suffix:
        return (
            f"Mend what the recording was made of, as {shlex.join(['daq', 'import', 'FILE', *options])} mends a file."
        )
    out = free_name(path.with_name(f"{path.stem}-healed.mcap"))
    return shlex.join(["daq", "import", str(path), "--out", str(out), *options])


def joint_list(joints: Sequence[int]) -> str:
    """The `joints` (from 1) in words."""
    return f"joint{'s' if len(joints) > 1 else ''} {', '.join(map(str, joints))}"

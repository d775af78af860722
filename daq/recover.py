"""Making an interrupted or damaged recording whole, and one whose samples are still only frames."""

import os
from dataclasses import dataclass
from pathlib import Path

from daq import listen
from recordings.container import load
from recordings.errors import BadInput
from recordings.reader import read_rig
from recordings.recovery import RewriteSummary, rewrite

_SAMPLES = ("/joint_states", "/joint_commands", "/amplifiers")
_END = {"exit_status": "1", "reason": "recovered after interruption"}


@dataclass(frozen=True)
class Recovered:
    """What became of a recording."""

    kept: RewriteSummary
    reconstructed: bool
    """The samples were made from the frames, as it was recorded by listening."""


def recover(source: Path, out: Path) -> Recovered:
    """Make a whole recording `out` of everything intact in `source`, which is not touched.

    Raises:
        BadInput: `source` is missing, is whole already, no recording, or holds nothing intact; `out` exists.
        OSError: `out` cannot be written.
    """
    if _is_whole(source):
        raise BadInput(f"recording {source} is whole; there is nothing to recover")
    kept = rewrite(source, out, _END)
    try:
        reconstructed = _complete(out)
    except BaseException:
        out.unlink(missing_ok=True)
        raise
    return Recovered(kept, reconstructed)


def recover_in_place(source: Path) -> Recovered:
    """The same, in the place of `source`."""
    partial = source.with_name(source.name + ".part")
    recovered = recover(source, partial)
    os.replace(partial, source)  # noqa: PTH105
    return recovered


def _is_whole(source: Path) -> bool:
    try:
        container = load(source, _SAMPLES)
    except BadInput:
        if source.is_file():
            return False  # damaged; what else may be wrong shows when it is copied
        raise
    return (
        not container.cut_off
        and "exit_status" in container.metadata.get("run", {})
        and any(container.batches.values())
    )


def _complete(path: Path) -> bool:
    """Make the samples of a recording that was made by listening."""
    container = load(path, (*_SAMPLES, "/can"))
    if any(container.batches.get(topic) for topic in _SAMPLES) or not container.batches.get("/can"):
        return False
    listen.complete(path, read_rig(path), None, _END)
    return True

"""Recovery of interrupted or damaged recordings, and of listened recordings without samples."""

from dataclasses import dataclass
from pathlib import Path

from daq.passive import listen
from recordings.container import load
from recordings.errors import BadInput
from recordings.files import replacement
from recordings.reader import read_rig
from recordings.recovery import RewriteSummary, rewrite

_SAMPLES = ("/joint_states", "/joint_commands", "/amplifiers")
_END = {"exit_status": "1", "reason": "recovered after interruption"}


@dataclass(frozen=True)
class Recovered:
    """Result of recovering a recording."""

    kept: RewriteSummary
    reconstructed: bool
    """The samples were reconstructed from the frames of a listened recording."""


def recover(source: Path, out: Path) -> Recovered:
    """Write everything intact in `source` to the complete recording `out`; `source` is not changed.

    Raises:
        BadInput: `source` is missing, is already complete, is no recording or holds nothing intact, or `out` exists.
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
    """Recover `source` and replace it by the complete recording."""
    with replacement(source) as partial:
        return recover(source, partial)


def _is_whole(source: Path) -> bool:
    try:
        container = load(source, _SAMPLES)
    except BadInput:
        if source.is_file():
            return False  # damaged; other errors appear when it is copied
        raise
    return (
        not container.cut_off
        and "exit_status" in container.metadata.get("run", {})
        and any(container.batches.values())
    )


def _complete(path: Path) -> bool:
    """Add the samples if the recording `path` holds only frames; return whether it did."""
    container = load(path, (*_SAMPLES, "/can"))
    if any(container.batches.get(topic) for topic in _SAMPLES) or not container.batches.get("/can"):
        return False
    listen.complete(path, read_rig(path), None, _END)
    return True

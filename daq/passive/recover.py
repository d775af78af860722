"""Recovery of interrupted or damaged recordings, and of listened recordings without samples."""

from dataclasses import dataclass, replace
from pathlib import Path

from daq.passive import listen
from recordings.container import load
from recordings.errors import BadInput
from recordings.files import replacement
from recordings.reader import read_rig
from recordings.recovery import RewriteSummary, rewrite
from recordings.rig import Rig

_SAMPLES = ("/joint_states", "/joint_commands", "/amplifiers")
_END = {"exit_status": "1", "reason": "recovered after interruption"}


@dataclass(frozen=True)
class Recovered:
    """Result of recovering a recording."""

    kept: RewriteSummary
    reconstructed: bool
    """The samples were reconstructed from the frames of a listened recording."""


def recover(source: Path, out: Path, rig: Rig | None = None) -> Recovered:
    """Write everything intact in `source` to the complete recording `out`; `source` is not changed.

    A file of another program becomes a complete one with its messages, and no recording.

    rig: in place of a record `rig` that is lost.

    Raises:
        BadInput: `source` is missing, is already complete, is no MCAP file or holds nothing intact, or `out` exists.
        OSError: `out` cannot be written.
    """
    whole = BadInput(f"recording {source} is whole; there is nothing to recover")
    if _is_whole(source):
        raise whole
    kept = rewrite(source, out, _END, rig=rig)
    try:
        if kept.foreign and kept.whole:
            raise whole
        described = not kept.foreign and (rig is not None or "rig" not in kept.lost_records)
        made = _complete(out) if described else 0
    except BaseException:
        out.unlink(missing_ok=True)
        raise
    return Recovered(replace(kept, rows=kept.rows + made), made > 0)


def recover_in_place(source: Path, rig: Rig | None = None) -> Recovered:
    """Recover `source` and replace it by the complete recording."""
    with replacement(source) as partial:
        return recover(source, partial, rig)


def _is_whole(source: Path) -> bool:
    try:
        container = load(source, _SAMPLES)
    except BadInput:
        if source.is_file():
            return False  # damaged; other errors appear when it is copied
        raise
    return (
        not container.cut_off
        and "rig" in container.metadata
        and "exit_status" in container.metadata.get("run", {})
        and any(container.batches.values())
    )


def _complete(path: Path) -> int:
    """Add the samples if the recording `path` holds only frames; return how many."""
    container = load(path, (*_SAMPLES, "/can"))
    if any(container.batches.get(topic) for topic in _SAMPLES) or not container.batches.get("/can"):
        return 0
    return len(listen.complete(path, read_rig(path), None, _END).samples.stamp)

"""Logs of CAN frames as `candump -l` of can-utils writes them: the samples are reconstructed from the frames."""

import itertools
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import can
import numpy as np

from daq.passive import listen
from daq.passive.reconstruct import Reconstructed
from recordings.buses import SerialBus
from recordings.errors import BadInput, RunFailed
from recordings.importing import Description, Imported
from recordings.reader import read
from recordings.rig import Rig

_LINE = re.compile(rb"\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#")


def recognises(path: Path) -> bool:
    """Whether `path` is such a log."""
    if not path.is_file():
        return False
    with path.open("rb") as stream:
        return bool(_LINE.match(stream.read(200)))


def import_log(path: Path, out: Path, description: Description, bus: str | None) -> Imported:
    """Write the frames in the log `path`, and the samples that they carry, as recording `out`.

    Args:
        description: of it the rig, start, robot and whether it is simulated; the rig says what the frames carry.
        bus: name in the log, such as can0; None: the only one.

    Raises:
        BadInput: the log holds a line that is no frame, several buses, no SYNC, or no answer of a drive,
            the rig has no drives on a CAN bus, or `out` exists. No partial file is left.
    """
    rig = description.rig
    if rig is None or not rig.drives or isinstance(rig.bus, SerialBus):
        raise BadInput(
            f"{path} is a log of CAN frames: a rig file with CANopen drives expected, none found; give --rig"
        )
    recorder = listen.FrameRecorder(
        out, rig, listen.listened_run(rig).model_copy(update={"robot": description.robot})
    )
    try:
        with recorder.writer as writer:
            first, left_out = _copy(path, recorder, bus)
            writer.close(0, "")
        made = listen.complete(out, rig, None, _end(path, description, first))
        _check_answers(path, rig, made)
        run = read(out).run
    except RunFailed:
        out.unlink()
        raise BadInput(
            f"{path}: SYNCs (id 080) expected, none found among {recorder.frames} frames; log the bus on "
            "which the master works"
        ) from None
    except BaseException:
        out.unlink(missing_ok=True)
        raise
    notes = [f"{recorder.frames} frames, {recorder.syncs} SYNCs, {made.missing} missing"]
    notes += [f"left out: {left_out} frames of CAN FD"] if left_out else []
    return Imported(rig, run, made.samples, run.trajectory_digest, tuple(notes))


def _end(path: Path, description: Description, first: int) -> dict[str, str]:
    """Entries of the record `run`; `first`: time of the first frame [ns]."""
    start = description.start or datetime.fromtimestamp(first / 1e9, UTC).isoformat(timespec="milliseconds")
    end = {"exit_status": "0", "reason": f"imported from {path.name}", "start": start}
    return end | ({"simulated": "true"} if description.simulated else {})


def _copy(path: Path, recorder: listen.FrameRecorder, interface: str | None) -> tuple[int, int]:
    """Record the frames of one bus; return the time of the first [ns], and how many of CAN FD were left out."""
    first, left_out = None, 0
    buses: set[str] = set()
    for message in _messages(path):
        if message.channel is not None:  # error frames come without
            buses.add(str(message.channel))
        if interface is None and len(buses) > 1:
            raise BadInput(f"{path}: several buses found: {', '.join(sorted(buses))}; choose one with --topic")
        if interface not in (None, str(message.channel)):
            continue
        stamp = round(message.timestamp * 1e6) * 1000  # the log tells microseconds
        first = stamp if first is None else first
        left_out += message.is_fd
        if not message.is_fd:
            recorder.add(stamp, message)
    if first is None:
        listed = ", ".join(sorted(buses)) or "no frame"
        raise BadInput(f"{path}: --topic: one of {listed} expected, {interface!r} found; choose one")
    return first, left_out


def _messages(path: Path) -> Iterator[can.Message]:
    """The frames of the log."""
    with can.CanutilsLogReader(path) as reader:
        messages = iter(reader)
        for count in itertools.count():
            try:
                yield next(messages)
            except StopIteration:
                return
            except (ValueError, IndexError):
                raise BadInput(
                    f"{path}: frames such as '(1436509052.249713) can0 044#2A36' expected, another line found behind "
                    f"{count} frames; remove it, or log with candump -l"
                ) from None


def _check_answers(path: Path, rig: Rig, made: Reconstructed) -> None:
    answered = np.logical_or.reduce(np.isfinite(made.samples.position), axis=0)
    silent = [drive.address for drive, known in zip(rig.drives, answered, strict=True) if not known]
    if silent:
        raise BadInput(
            f"{path}: positions in the PDOs of all drives of the rig file expected, none of {', '.join(silent)} "
            "found; correct node_id and PDOs in the rig file"
        )

"""Logs of CAN frames as candump of can-utils writes them: the samples are reconstructed from the frames.

`candump -l` writes `(1436509052.249713) can0 044#2A366C`. What it shows on a console, and people save, is
`(1436509052.249713)  can0  044   [3]  2A 36 6C`; with `-t d`, its times are steps.
"""

import re
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import can
import numpy as np

from daq.passive import listen
from daq.passive.reconstruct import Reconstructed
from recordings.buses import SerialBus
from recordings.errors import BadInput, RunFailed
from recordings.importing import Description, Imported
from recordings.reader import read
from recordings.rig import Rig

_START = r"""\s* (?: \( (?: (?P<date>\d{4}-\d\d-\d\d\ [\d:]{8}) | (?P<epoch>[0-8]\d{9}) | (?P<since>\d{1,9}) )
      \. (?P<fraction>\d{1,9}) \) \s* )?
    (?P<bus>[^\s(]\S*) \s+ (?: [RT]X \s+ [-B] \s+ [-E] \s+ )? (?P<id>[\dA-F]{3}|[\dA-F]{8})
    (?: \# | \s+ [\[{] (?P<length>[\dA-F]{1,4}) [\]}] )"""
"""What a line begins with, in a log, and on a console with the options -t and -x."""
_LINE = re.compile(
    _START
    + r"""(?:
      (?<=\#) (?: (?P<data>(?:[\dA-F]{2}\.?){0,8}) (?:_[\dA-F])? | (?P<remote>R\w*) | (?P<fd>\#.*?) ) (?:\s+[RT])?
      | (?<=[\]}]) \s* (?: (?P<request>remote\ request) | (?P<shown>(?:[\dA-F]{2}(?:\s|$))*) )
        (?: \s+ (?:ERRORFRAME|'.*') )?
      | (?<=\d\d\]) .* ) \s*""",
    re.VERBOSE,
)
"""A frame; those of CAN FD are `fd`, or have a length of two digits."""
_COLOUR = re.compile(r"\x1b\[[\d;]*m")
_DROPPED = re.compile(r"DROPCOUNT: dropped (\d+) CAN frame")
_HEAD = 4096
"""Number of bytes by which a log is recognised."""
_ERROR, _NUMBER = 0x2000_0000, 0x1FFF_FFFF
"""Flag of error frames, and bits of the id of a frame."""
_LONGEST_CYCLE = 100
"""Number of frames from one SYNC to the next, at most."""
_PAUSE, _LONGEST = 500_000_000, int(listen.SYNC_TIMEOUT * 1e9)
"""Times without a frame: one that is told, and the longest that counts [ns]."""
_EARLIEST = 10**9
"""Time of the first frame, at least [ns]: the line through the SYNCs may begin a little before, but not before 0."""
_LISTED = 5
"""Number of jumps of the clock that are listed."""


def recognises(path: Path) -> bool:
    """Whether `path` is such a log."""
    if not path.is_file():
        return False
    with path.open("rb") as stream:
        lines = stream.read(_HEAD).decode("utf-8", "replace").splitlines()
    return any(re.match(_START, _COLOUR.sub("", line), re.VERBOSE) for line in lines)


def import_log(path: Path, out: Path, description: Description, bus: str | None) -> Imported:
    """Write the frames in the log `path`, and the samples that they carry, as recording `out`.

    Args:
        description: of it the rig, start, robot and whether it is simulated; the rig says what the frames carry.
        bus: name in the log, such as can0; None: the only one.

    Raises:
        BadInput: the log holds a line that is no frame with its time, several buses, no SYNC, or no answer of a
            drive, the rig has no drives on a CAN bus, or `out` exists. No partial file is left.
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
            first, further = _copy(path, recorder, bus)
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
    return Imported(rig, run, made.samples, run.trajectory_digest, (*notes, *further))


def _end(path: Path, description: Description, first: int) -> dict[str, str]:
    """Entries of the record `run`; `first`: time of the first frame [ns]."""
    start = description.start or datetime.fromtimestamp(first / 1e9, UTC).isoformat(timespec="milliseconds")
    end = {"exit_status": "0", "reason": f"imported from {path.name}", "start": start}
    return end | ({"simulated": "true"} if description.simulated else {})


class _Frame(NamedTuple):
    stamp: int
    """As it stands in the log [ns]."""
    may_be_step: bool
    bus: str
    id: int
    message: can.Message | None
    """None for one of CAN FD."""


def _copy(path: Path, recorder: listen.FrameRecorder, interface: str | None) -> tuple[int, list[str]]:
    """Record the frames of one bus; return the time of the first [ns], and what was left out or mended."""
    left_out: Counter[str] = Counter()
    are_steps, buses, clock, stamp = _are_steps(path), set[str](), _Clock(), 0
    for line, frame in _frames(path, left_out):
        buses.add(frame.bus)
        if interface is None and len(buses) > 1:
            raise BadInput(f"{path}: several buses found: {', '.join(sorted(buses))}; choose one with --topic")
        stamp = frame.stamp + (stamp if are_steps else 0)
        if interface in (None, frame.bus):
            time = clock.time(line, stamp, frame.id)
            if frame.message is None:
                left_out["frames of CAN FD"] += 1
            else:
                recorder.add(time, frame.message)
    if clock.first is None:
        listed = ", ".join(sorted(buses)) or "no frame"
        raise BadInput(f"{path}: --topic: one of {listed} expected, {interface!r} found; choose one")
    lost = ", ".join(f"{count} {what}" for what, count in left_out.items())
    jumps = ", ".join([*clock.jumps[:_LISTED], *["..."] * (len(clock.jumps) > _LISTED)])
    notes = [f"left out: {lost}"] * bool(lost)
    if jumps:
        most = f"{_LONGEST / 1e9:g} s"
        notes.append(f"the clock jumps in {jumps}; back, time goes on; ahead, it is a pause of at most {most}")
    return clock.first, notes


class _Clock:
    """The time of one bus, which goes on where the clock of its log jumps."""

    def __init__(self) -> None:
        self.first: int | None = None
        self.jumps: list[str] = []
        self._time = self._shift = self._id = 0
        self._steps: dict[tuple[int, int], int] = {}
        """The last one from a frame of one id to that of another."""

    def time(self, line: int, stamp: int, number: int) -> int:
        """Time [ns] of the frame with the id `number` at the `stamp` [ns] in a `line`."""
        if self.first is None:
            self.first, self._time = stamp, max(stamp, _EARLIEST)
            self._shift = self._time - stamp
        step, pair = stamp + self._shift - self._time, (self._id, number)
        if 0 <= step <= _PAUSE:
            self._steps[pair] = step
        else:
            self.jumps.append(f"line {line} by {step / 1e9:+g} s")
            usual = self._steps.get(pair, 0) if step < 0 else min(step, _LONGEST)
            self._shift, step = self._shift + usual - step, usual
        self._time, self._id = self._time + step, number
        return self._time


def _are_steps(path: Path) -> bool:
    """Whether times of the log are those from one frame to the next: these fall in every cycle, other ones rise."""
    before = frames = rises = falls = 0
    for _, frame in _frames(path, Counter()):
        if not frame.may_be_step:
            return False
        frames, rises, falls = frames + 1, rises + (frame.stamp > before), falls + (2 * frame.stamp < before)
        before = frame.stamp
    return falls * _LONGEST_CYCLE > frames or rises < 2


def _frames(path: Path, left_out: "Counter[str]") -> Iterator[tuple[int, _Frame]]:
    """Frames of the log with their lines; `left_out` counts what else it tells to be lost."""
    with path.open(encoding="utf-8-sig", errors="replace") as lines:
        for number, text in enumerate(lines, start=1):
            line = _COLOUR.sub("", text).rstrip()
            if frame := _frame(line):
                yield number, frame
            elif dropped := _DROPPED.match(line):
                left_out["frames that candump lost"] += int(dropped[1])
            elif line and not text.endswith("\n"):
                left_out["line at the end, which is cut off"] += 1
            elif line and not line.startswith("\t"):  # as what explains an error frame
                raise BadInput(
                    f"{path}, line {number}: a frame with its time, such as '(1436509052.249713) can0 044#2A36', "
                    f"expected, {line.strip()[:60]!r} found; remove the line, or log with candump -l"
                )


def _frame(line: str) -> _Frame | None:
    """The frame in a `line`; None if there is none, or without a time."""
    match = _LINE.fullmatch(line)
    if match is None or match["fraction"] is None:
        return None
    number, length = int(match["id"], 16), match["length"] or ""
    data = bytes.fromhex((match["data"] or match["shown"] or "").replace(".", ""))
    if match["shown"] is not None and len(length) == 1 and len(data) != min(int(length, 16), 8):
        return None
    try:
        seconds = int(match["epoch"] or match["since"] or datetime.fromisoformat(match["date"] + "Z").timestamp())
    except ValueError:
        return None
    message = can.Message(
        arbitration_id=number & _NUMBER,
        is_extended_id=len(match["id"]) > 3 and not number & _ERROR,
        is_remote_frame=bool(match["remote"] or match["request"]),
        is_error_frame=bool(number & _ERROR),
        data=data,
    )
    return _Frame(
        stamp=seconds * 10**9 + int(match["fraction"].ljust(9, "0")),
        may_be_step=bool(match["since"] and length),
        bus=match["bus"],
        id=number,
        message=None if match["fd"] or len(length) > 1 else message,
    )


def _check_answers(path: Path, rig: Rig, made: Reconstructed) -> None:
    answered = np.logical_or.reduce(np.isfinite(made.samples.position), axis=0)
    silent = [drive.address for drive, known in zip(rig.drives, answered, strict=True) if not known]
    if silent:
        raise BadInput(
            f"{path}: positions in the PDOs of all drives of the rig file expected, none of {', '.join(silent)} "
            "found; correct node_id and PDOs in the rig file"
        )

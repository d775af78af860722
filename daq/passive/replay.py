"""Replay of the frames of a recording on a bus, in their order and with their timing."""

import errno
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import can
import numpy as np
from numpy.typing import NDArray

from daq.cycle.stopping import StopRequest
from drivers.canopen.bus import frame_bits
from drivers.canopen.requirements import MASTER_ID, SYNC_ID
from recordings.errors import BadInput, RunFailed
from recordings.recording import Bools, CanFrames, Floats

Direction = Literal["tx", "rx", "both"]

_IDS = re.compile(r"(0[xX][\da-fA-F]+|\d+)(?:([-/])(0[xX][\da-fA-F]+|\d+))?")
_START_DELAY = 0.02
"""Time from the call to the first frame [s]."""
_POLL_INTERVAL = 0.1
"""Longest time between two checks for a stop request [s]."""
_MAX_AHEAD = 0.005
"""Time on the wire of frames that may be sent ahead of the wire [s]."""
_FULL_TIMEOUT = 1.0
"""Time for which the interface may be full before the bus counts as lost [s]."""
_BLOCK = 10_000
"""Number of frames that are unpacked at a time."""


def matching(frames: CanFrames, direction: Direction, ids: Sequence[str]) -> Bools:
    """Mask (n,) of the frames with this direction and, if `ids` are given, one of these ids.

    An entry of `ids` is a single id ("0x181"), a range ("0x181-0x183"), or value/mask as in candump ("0x180/0x780").
    Error frames cannot be sent and never match.

    Raises:
        BadInput: an entry of `ids` has another form.
    """
    chosen = ~frames.error
    if direction != "both":
        chosen &= frames.sent == (direction == "tx")
    if ids:
        chosen &= np.logical_or.reduce([_has_id(frames, text) for text in ids])
    return chosen


def _has_id(frames: CanFrames, text: str) -> Bools:
    match = _IDS.fullmatch(text.strip())
    if match is None:
        raise BadInput(f"--id: 0x181, 0x181-0x183 or 0x180/0x780 (value/mask) expected, {text!r} found")
    # Base 0 rejects a decimal number with leading zeros, because its base is ambiguous.
    try:
        first, last = int(match[1], 0), int(match[3] or match[1], 0)
    except ValueError:
        raise BadInput(f"--id: {text!r} has leading zeros; write 0x before a hexadecimal number") from None
    if match[2] == "/":
        return (frames.id & last) == (first & last)
    if first > last:
        raise BadInput(f"--id: a range from a lower to a higher id expected, {text!r} found")
    return (frames.id >= first) & (frames.id <= last)


def commanding(frames: CanFrames) -> Bools:
    """Mask (n,) of the frames that command drives: those of the master, whichever program recorded them.

    These are NMT, SYNC, time, RPDOs, SDO requests and the master's heartbeat, and all frames that were sent.
    """
    function = frames.id & 0x780
    broadcast = np.isin(frames.id, (0x000, SYNC_ID, 0x100, 0x700 + MASTER_ID))
    from_master = broadcast | np.isin(function, (0x200, 0x300, 0x400, 0x500, 0x600))
    return frames.sent | (from_master & ~frames.extended)


@dataclass(frozen=True)
class ReplayPlan:
    """Frames to send and their deadlines."""

    frames: CanFrames
    rows: NDArray[np.intp]
    """Positions of the chosen frames (m,)."""
    due: Floats
    """Deadline of each frame after the first one (m,) [s]."""
    wire: Floats
    """Duration of each frame on the wire (m,) [s]."""
    loops: int
    loop_time: float
    """Time from one loop to the next [s]."""

    @property
    def total(self) -> int:
        """Number of frames in all loops."""
        return self.loops * len(self.rows)

    @property
    def duration(self) -> float:
        """Duration of all loops [s]."""
        return (self.loops - 1) * self.loop_time + float(self.due[-1])


def plan(frames: CanFrames, chosen: Bools, speed: float, loops: int, bitrate: int) -> ReplayPlan:
    """Plan `loops` replays of the `chosen` frames at `speed` times the recorded speed; `bitrate` of the bus [bit/s].

    Raises:
        BadInput: no frame is chosen.
    """
    rows = np.flatnonzero(chosen)
    if not len(rows):
        raise BadInput(
            f"frames to replay expected, none of {len(frames.id)} recorded ones is chosen; check --direction and --id"
        )
    due = (frames.log[rows] - frames.log[rows[0]]) / 1e9 / speed
    return ReplayPlan(
        frames=frames,
        rows=rows,
        due=due,
        wire=frame_bits(frames.dlc[rows]) / bitrate,  # type: ignore[arg-type]
        loops=loops,
        loop_time=float(due[-1]) + _typical_step(frames, rows, due),
    )


def _typical_step(frames: CanFrames, rows: NDArray[np.intp], due: Floats) -> float:
    """Median time from one cycle to the next [s], so that a new loop continues the rhythm of the SYNCs."""
    syncs = due[frames.id[rows] == SYNC_ID]
    steps = np.diff(syncs if len(syncs) > 1 else due)
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else 0.0


@dataclass(frozen=True, eq=False)
class Replayed:
    """Result of a replay."""

    sent: int
    lateness: Floats
    """Lateness of each frame after its deadline (sent,) [s]."""
    stopped: str | None
    """Reason why the replay was stopped; None if all frames were sent."""


def replay(
    plan: ReplayPlan, bus: can.BusABC, stop: StopRequest, show: Callable[[int], None] = lambda sent: None
) -> Replayed:
    """Send the frames at absolute deadlines, so that lateness does not accumulate, but no faster than the wire.

    Frames that were recorded at one instant (simulated time stands still between SYNCs) follow each other at the
    speed of the wire.

    Raises:
        RunFailed: the bus does not accept frames.
    """
    start = time.perf_counter() + _START_DELAY
    lateness = np.zeros(plan.total)
    sent, wire_free = 0, 0.0
    for loop in range(plan.loops):
        for due, wire, message in _messages(plan):
            deadline = loop * plan.loop_time + due
            deadline = max(deadline, wire_free - _MAX_AHEAD)
            wire_free = max(wire_free, deadline) + wire
            if not _wait(start + deadline, stop):
                return Replayed(sent, lateness[:sent], stop.reason)
            _send(bus, message)
            lateness[sent] = max(0.0, time.perf_counter() - start - deadline)
            sent += 1
            show(sent)
    return Replayed(sent, lateness, None)


def _messages(plan: ReplayPlan) -> Iterator[tuple[float, float, can.Message]]:
    frames = plan.frames
    for first in range(0, len(plan.rows), _BLOCK):
        block = slice(first, first + _BLOCK)
        rows = plan.rows[block]
        columns: list[list[Any]] = [
            values[rows].tolist() for values in (frames.id, frames.dlc, frames.extended, frames.rtr)
        ]
        data = map(bytes, frames.data[rows])
        for due, wire, arbitration_id, dlc, extended, rtr, content in zip(
            plan.due[block].tolist(), plan.wire[block].tolist(), *columns, data, strict=True
        ):
            yield (
                due,
                wire,
                can.Message(
                    arbitration_id=arbitration_id,
                    dlc=dlc,
                    data=None if rtr else content[:dlc],
                    is_extended_id=extended,
                    is_remote_frame=rtr,
                ),
            )


def _wait(deadline: float, stop: StopRequest) -> bool:
    """Wait until `deadline` (performance counter, [s]); return False at once on a stop request."""
    while not stop.count:
        remaining = deadline - time.perf_counter()
        if remaining <= 0:
            return True
        time.sleep(min(remaining, _POLL_INTERVAL))
    return False


def _send(bus: can.BusABC, message: can.Message) -> None:
    end = time.perf_counter() + _FULL_TIMEOUT
    while True:
        try:
            bus.send(message)
            return
        except (can.CanError, OSError) as error:
            code = getattr(error, "error_code", None) or getattr(error, "errno", None)
            if code != errno.ENOBUFS or time.perf_counter() > end:
                raise RunFailed(f"the CAN bus does not accept frames: {error}") from None
            time.sleep(1e-4)  # the queue of the interface is full: the wire is slower than the replay

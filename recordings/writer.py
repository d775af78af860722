"""Writing a recording: an MCAP file of ROS 2 messages that stays readable when truncated."""

import contextlib
import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn, Self

import numpy as np
from mcap.writer import Writer
from numpy.typing import NDArray

from recordings import schemas
from recordings.cdr import Encoder
from recordings.container_writer import LIBRARY, PROFILE
from recordings.description import description_messages
from recordings.errors import BadInput, RunFailed
from recordings.files import create
from recordings.metadata import clean, rig_record, run_record
from recordings.recording import Run
from recordings.rig import Rig

FLUSH_INTERVAL = 250_000_000
"""Interval of flushes [ns]: the largest recorded time lost when the program is killed."""
_SYNC_INTERVAL = 0.5
"""Pause between two times at which the file is brought to the disk [s]: what is lost when the power fails."""

Numbers = Sequence[float] | NDArray[np.float64]


class RecordingFailed(RunFailed, BadInput):
    """The file cannot be written any further, usually because the disk is full.

    It ends the run as any RunFailed, but the user can fix it, so the exit code is 2 as for bad input.
    """


@cache
def joint_state_encoder(names: tuple[str, ...], velocity: bool = False, effort: bool = False) -> Encoder:
    """Return the encoder of sensor_msgs/msg/JointState: time, positions, then velocities and efforts if measured."""
    dof = len(names)
    texts = {"header.frame_id": ""} | {f"name.{i}": name for i, name in enumerate(names)}
    lengths = {"name": dof, "position": dof, "velocity": dof * velocity, "effort": dof * effort}
    return Encoder(schemas.FIELDS["/joint_states"], texts, lengths)


class _DiskSync:
    """Brings an open file to the disk now and then, in a thread: a slow disk must not delay a cycle."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor, self._ended = descriptor, threading.Event()
        self._thread = threading.Thread(target=self._run, name="disk-sync", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Bring it there a last time; without effect where it has ended."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        running = True
        while running:
            running = not self._ended.wait(_SYNC_INTERVAL)
            with contextlib.suppress(OSError):  # a full disk is told by the next write
                os.fsync(self._descriptor)


class RecordingWriter:
    """Writes one recording; a context manager. Not thread-safe.

    Times are in nanoseconds: `stamp_ns` is the SYNC instant (for a frame, its timestamp), `log_ns` the arrival time
    at the host. No other time enters the file, so the same calls give the same bytes. Leaving the context closes
    the recording; after an exception, with exit status 1 and the error as the reason.

    Every method raises RecordingFailed where the file cannot be written; data written before stay readable.
    """

    def __init__(self, path: Path, rig: Rig, run: Run) -> None:
        """Create the file and write the metadata records `rig` and `run`.

        Raises:
            BadInput: the file exists, or cannot be created.
        """
        self._path = path
        self._joints = rig.joint_names
        self._flushed: int | None = None
        arrays = dict.fromkeys(("voltage", "voltage_stamp", "statusword", "error_code"), len(self._joints))
        self._amplifiers = Encoder(schemas.FIELDS["/amplifiers"], {"header.frame_id": ""}, arrays)
        self._extra: Encoder | None = None
        self._point = Encoder(schemas.FIELDS["/platform_reference"], {"header.frame_id": "base"}, {})
        self._sent, self._received = (
            Encoder(schemas.FIELDS["/can"], {"header.frame_id": direction}, {}) for direction in ("tx", "rx")
        )
        self._stream = create(path)
        self._disk = _DiskSync(self._stream.fileno())
        self._open = True
        # Any: some methods of the library lack annotations.
        self._mcap: Any = Writer(self._stream, enable_data_crcs=True)
        try:
            self._mcap.start(profile=PROFILE, library=LIBRARY)
            self._description = description_messages(rig)
            topics = *schemas.TOPICS, *schemas.DESCRIPTION_TOPICS
            self._channels = {topic: self._register(topic) for topic in topics}
            self._mcap.add_metadata("rig", rig_record(rig))
            self._mcap.add_metadata("run", run_record(run))
            self._stream.flush()
        except OSError as error:
            path.unlink(missing_ok=True)  # the empty file would block the next run
            self._fail(error)

    def joint_states(
        self,
        stamp_ns: int,
        log_ns: int,
        position: Numbers,
        velocity: Numbers | None = None,
        effort: Numbers | None = None,
    ) -> None:
        """Write measured joint positions [rad], NaN where lost; velocities [rad/s] and efforts [N m] if measured."""
        encoder = joint_state_encoder(self._joints, velocity is not None, effort is not None)
        measured = [values for values in (position, velocity, effort) if values is not None]
        self._add("/joint_states", stamp_ns, log_ns, encoder, chain(*measured))

    def joint_commands(self, stamp_ns: int, log_ns: int, position: Numbers) -> None:
        """Write the joint reference [rad] sent for this SYNC."""
        self._add("/joint_commands", stamp_ns, log_ns, joint_state_encoder(self._joints), position)

    def amplifiers(
        self,
        stamp_ns: int,
        log_ns: int,
        cycle: int,
        repeat: int,
        lateness: float,
        voltage: Numbers,
        statusword: Sequence[int],
        error_code: Sequence[int],
        voltage_stamp_ns: Sequence[int] | None = None,
    ) -> None:
        """Write the amplifiers' answers to SYNC number `cycle`: voltages [V], NaN where not fresh; host lateness [s].

        `voltage_stamp_ns` holds the measurement times of the voltages if they differ from the SYNC instant.
        """
        instants = [stamp_ns] * len(self._joints) if voltage_stamp_ns is None else voltage_stamp_ns
        voltage_stamps = [number for instant in instants for number in divmod(instant, 10**9)]
        values = (cycle, repeat, lateness, *voltage, *voltage_stamps, *statusword, *error_code)
        self._add("/amplifiers", stamp_ns, log_ns, self._amplifiers, values)

    def extra(self, stamp_ns: int, log_ns: int, values: Mapping[str, float]) -> None:
        """Write further values of this SYNC; the names must be the same in every call."""
        if self._extra is None:
            texts = {"header.frame_id": ""} | {f"name.{i}": name for i, name in enumerate(values)}
            self._extra = Encoder(schemas.FIELDS["/extra"], texts, {"name": len(values), "value": len(values)})
            self._channels["/extra"] = self._register("/extra")
        self._add("/extra", stamp_ns, log_ns, self._extra, values.values())

    def platform_reference(self, stamp_ns: int, log_ns: int, xyz: Numbers) -> None:
        """Write the platform position [m] of the reference."""
        self._add("/platform_reference", stamp_ns, log_ns, self._point, xyz)

    def can(
        self,
        stamp_ns: int,
        log_ns: int,
        arbitration_id: int,
        data: bytes,
        *,
        sent: bool,
        rtr: bool = False,
        extended: bool = False,
        error: bool = False,
    ) -> None:
        """Write one CAN frame, of CAN FD its first 8 bytes; `sent` is False for received frames."""
        data = data[:8]
        values = (arbitration_id, rtr, extended, error, len(data), *data.ljust(8, b"\0"))
        self._add("/can", stamp_ns, log_ns, self._sent if sent else self._received, values)

    def event(self, log_ns: int, level: schemas.Level, source: str, message: str) -> None:
        """Write an event: a state change, EMCY, missed cycle, or a stop and its reason."""
        encoder = Encoder(schemas.FIELDS["/events"], {"name": source, "msg": message, "file": "", "function": ""}, {})
        self._add("/events", log_ns, log_ns, encoder, (schemas.LEVELS[level], 0))

    def close(self, exit_status: int, reason: str) -> None:
        """Write the end of the run and the summary; without effect on a closed recording."""
        if not self._open:
            return
        try:
            # The end of the run is written after the last chunk.
            self._mcap.flush()
            self._mcap.add_metadata("run", {"exit_status": str(exit_status), "reason": clean(reason)})
            self._mcap.finish()
            self._stream.flush()
            self._disk.end()
            self._stream.close()
            self._open = False
        except OSError as error:
            self._fail(error)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if error is None:
            self.close(0, "done")
        else:
            self.close(1, str(error) or type(error).__name__)

    def _register(self, topic: str) -> int:
        name, text = schemas.ALL_TOPICS[topic]
        schema: int = self._mcap.register_schema(name, "ros2msg", text.encode())
        return self._mcap.register_channel(topic, "cdr", schema)

    def _add(self, topic: str, stamp_ns: int, log_ns: int, encoder: Encoder, values: Iterable[float]) -> None:
        """Write a message that begins with its stamp, and flush now and then."""
        payload = encoder.pack([*divmod(stamp_ns, 10**9), *values])
        if not self._open:
            raise RecordingFailed(f"recording {self._path} is closed; nothing more can be recorded")
        try:
            if self._flushed is None:
                self._flushed = log_ns
                for about, message in self._description.items():
                    self._mcap.add_message(self._channels[about], log_ns, message, stamp_ns)
            elif log_ns - self._flushed >= FLUSH_INTERVAL:
                # Recorded time, not the wall clock, so that a simulated run is reproducible byte for byte.
                self._mcap.flush()
                self._flushed = log_ns
            self._mcap.add_message(self._channels[topic], log_ns, payload, stamp_ns)
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> NoReturn:
        self._disk.end()
        # Close the raw file below the buffer: flushing the buffer would fail again.
        self._stream.raw.close()
        self._open = False
        raise RecordingFailed(
            f"recording {self._path} cannot be written: {error.strerror or error}; free some space and record again"
        ) from error

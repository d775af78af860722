"""Reconstruction of samples from the frames of the bus and the PDO maps of the rig."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from daq.cycle.progress import loss_of
from daq.passive.sync_line import fit_line, number_syncs
from drivers import cia402
from drivers.canopen import emcy, pdo, requirements
from drivers.canopen.dictionary import standard_dictionary
from recordings.blocks import SampleTable
from recordings.container import Batch, load
from recordings.cycles import find_cycles
from recordings.recording import Floats, Ints
from recordings.rig import Drive, Rig
from trajectories import Trajectory

_TARGET = np.dtype([("controlword", "<u2"), ("counts", "<i4")])
_TARGET_WITH_OFFSET = np.dtype([*_TARGET.descr, ("torque_offset", "<i2")])
"""RPDO 1 without and with torque offset, as `drivers.canopen.pdo` maps it; told apart by the length of the frame."""
_STATE_BITS = 0x6F
"""Bits of the statusword that encode the drive state."""
_MAX_GAP = 500
"""Largest number of missing SYNCs in a row that count as lost samples; a longer gap is a pause of the master."""
Motion = Callable[[int | None], Trajectory]
"""Makes the trajectory of a motion with the number of cycles that the commands tell; None: as many as usual."""
_ANCHOR_COUNT = 40
"""Number of rows of a trajectory that are compared with the commands to locate it."""
_MIN_AGREEMENT = 0.9
"""Share of these rows that must agree."""
_CLOCKS = 1e-3
"""Relative difference of rates that the clocks of two computers explain."""
_SIMULATED_NAME = b"simulated drive"
"""Part of the device name (object 1008) of simulated drives."""

_FRAME = np.dtype([("id", "<u2"), ("length", "u1"), ("log", "<i8"), ("data", "u1", (8,))])


@dataclass(frozen=True, eq=False)
class Reconstructed:
    """Samples reconstructed from frames, and properties of the run."""

    samples: SampleTable
    rate: float
    """SYNCs per second [Hz]."""
    configured_rate: float
    """That of the rig file [Hz]."""
    missing: int
    """Number of missing SYNCs, without those of a pause of the master."""
    period: float
    """Period of the motion [s]; 0 if it does not repeat."""
    cycles: int
    trajectory: Trajectory | None
    """That of the given motion if it was commanded, else None."""
    simulated: bool
    """A device name says that the drive is simulated."""

    def figures(self) -> dict[str, Any]:
        """Summary for the console and for `--json`."""
        return {
            "samples": len(self.samples.stamp),
            "syncs_missing": self.missing,
            "answers_lost": np.isnan(self.samples.position).sum(axis=0).tolist(),
            "rate_hz": self.rate,
            "configured_rate_hz": self.configured_rate,
            "stamps": "SYNC index x configured period"
            if self.rate == self.configured_rate
            else "line through the arrivals",
            "trajectory": self.trajectory.name if self.trajectory else None,
            "cycles": self.cycles,
            "period_s": self.period,
            "simulated": self.simulated,
        }

    def other_rate(self) -> str | None:
        """What is to be said where the rate is not that of the rig file; None: it is."""
        if abs(self.rate / self.configured_rate - 1) <= _CLOCKS:
            return None
        lockstep = "; simulated drives in lockstep are recorded with --pace lockstep" if self.simulated else ""
        return (
            f"{self.configured_rate:g} SYNCs per second expected, as `rate` of the rig file says, {self.rate:.4g} "
            f"found; the recording has those found; correct the rig file, or the master{lockstep}"
        )

    def loss(self) -> str | None:
        """What is to be said where many answers are missing, from the first answer to the last; None: few are."""
        missing = np.isnan(self.samples.position)
        answered = np.flatnonzero(~missing.all(axis=1))
        if len(answered):  # a master may send SYNCs before it starts the drives
            missing = missing[answered[0] : answered[-1] + 1]
        lost = int(missing.sum())
        cause = "their SYNCs were heard: check the cable, and the node IDs and PDOs of the rig file"
        if 2 * self.missing * missing.shape[1] >= lost:
            cause = f"{self.missing} SYNCs are missing, too: close other programs, check the CAN adapter"
        return loss_of(lost, missing.size, cause)


def reconstruct(
    path: Path, rig: Rig, motion: Motion | None = None, *, lockstep: bool = False
) -> Reconstructed | None:
    """Reconstruct the samples from the frames in the recording `path`; None if there is no SYNC among them.

    The repetitions are those of `motion` if it was commanded; else they are detected in the motion. If the motion
    does not repeat, all samples with every drive enabled count as one repetition.

    lockstep: each SYNC waits for the answers to the one before, and so tells no time: the rate is that of the rig.

    Raises:
        BadInput: the file cannot be read.
    """
    frames = _frames(path)
    sync_positions = np.flatnonzero(frames["id"] == requirements.SYNC_ID)
    if not len(sync_positions):
        return None
    arrival = frames["log"][sync_positions]
    index, start, period = np.arange(len(arrival)), int(arrival[0]), 1e9 / rig.rate
    if not lockstep:
        index = number_syncs(arrival)
        start, period = fit_line(arrival, index, period)
    table = _FrameTable(frames, sync_positions, index)
    axes = [_joint_values(table, rig, joint) for joint in range(len(rig.drives))]
    joints = {name: np.column_stack([axis[name] for axis in axes]) for name in axes[0]}
    stamp = start + np.rint(table.sync_number * period).astype(np.int64)
    log = stamp.copy()
    log[table.rows] = arrival
    repeat, motion_period, matched_trajectory = _repeat(rig, joints, motion)
    measured: dict[str, Any] = joints if pdo.measures_effort(rig) else joints | {"effort": None}
    return Reconstructed(
        samples=SampleTable(rig.joint_names, stamp, log, table.sync_number, repeat, **measured),
        rate=rig.rate if period == 1e9 / rig.rate else 1e9 / period,
        configured_rate=rig.rate,
        missing=len(stamp) - len(index),
        period=motion_period * period / 1e9,
        cycles=max(int(repeat.max()) + 1, 1),
        trajectory=matched_trajectory,
        simulated=_is_simulated(frames, rig),
    )


def _frames(path: Path) -> NDArray[Any]:
    """Read the standard data frames in the order of arrival, in compact form."""
    batches = load(path, ("/can",), _compact).batches.get("/can", [])
    return np.concatenate([np.empty(0, _FRAME), *batches])


def _compact(batch: Batch) -> NDArray[Any]:
    message = batch["message"]
    plain = ~(message["is_rtr"] | message["is_extended"] | message["is_error"])
    frames = np.empty(int(plain.sum()), _FRAME)
    frames["id"], frames["length"] = message["id"][plain], message["dlc"][plain]
    frames["log"], frames["data"] = batch["log"][plain], message["data"][plain]
    return frames


class _FrameTable:
    """Assignment of frames to rows: one row per SYNC, including missing ones."""

    def __init__(self, frames: NDArray[Any], sync_positions: Ints, index: Ints) -> None:
        """`sync_positions`: positions of the SYNCs among the frames; `index`: their numbers."""
        self._frames = frames
        self._sync_positions = sync_positions
        steps = np.diff(index)
        gaps = np.flatnonzero((steps > 1) & (steps <= _MAX_GAP))
        lost = [np.arange(index[i] + 1, index[i + 1]) for i in gaps]
        self.sync_number: Ints = np.unique(np.concatenate([index, *lost]))
        """SYNC number of every row (n,)."""
        self.rows: Ints = np.searchsorted(self.sync_number, index)
        """Row of each received SYNC."""

    def contents(self, arbitration_id: int, layout: np.dtype[Any], sync: Literal[-1, 0]) -> tuple[Ints, NDArray[Any]]:
        """Rows and contents of the frames that answer the SYNC before them (-1) or take effect with the next one (0);
        the last frame counts."""
        frames = self._frames
        matching = np.flatnonzero((frames["id"] == arbitration_id) & (frames["length"] == layout.itemsize))
        numbers = np.searchsorted(self._sync_positions, matching) + sync
        inside = (numbers >= 0) & (numbers < len(self._sync_positions))
        data = np.ascontiguousarray(frames["data"][matching[inside], : layout.itemsize])
        return self.rows[numbers[inside]], data.view(layout)[:, 0]

    def latest(self, arbitration_id: int, value: Callable[[bytes], int]) -> Ints:
        """`value` (n,) of the last such frame before the next SYNC; 0 before the first frame."""
        matching = np.flatnonzero(self._frames["id"] == arbitration_id)
        values = [value(bytes(frame["data"][: frame["length"]])) for frame in self._frames[matching]]
        ends = np.append(self._sync_positions[1:], len(self._frames))
        latest_value = np.array([0, *values])[np.searchsorted(matching, ends)]
        filled: Ints = np.zeros(len(self.sync_number), np.int64)
        filled[self.rows] = latest_value
        return filled


def _answers(table: _FrameTable, drive: Drive) -> dict[str, Floats]:
    """Raw values (n,) in the drive's TPDOs: of the size of the voltage object with which most frames can be read."""
    best: dict[str, Floats] = {}
    most = -1
    for pdos in pdo.tpdos_by_size(drive):
        raw = {name: np.full(len(table.sync_number), np.nan) for name in ("status", "position", "voltage", "torque")}
        count = 0
        for tpdo in pdos:
            layout = np.dtype([(field.name, "<" + field.layout) for field in tpdo.fields])
            rows, contents = table.contents(tpdo.cob_id, layout, -1)
            count += len(rows)
            for field in tpdo.fields:
                raw[field.name][rows] = contents[field.name]
        if count > most:
            best, most = raw, count
    return best


def _joint_values(table: _FrameTable, rig: Rig, joint: int) -> dict[str, NDArray[Any]]:
    """Values of one joint, (n,) each, by their names in `SampleTable`."""
    n, drive = len(table.sync_number), rig.drives[joint]
    raw = _answers(table, drive)
    target = np.full(n, np.nan)
    command = pdo.rpdos(standard_dictionary(drive))[0].cob_id
    for layout in (_TARGET, _TARGET_WITH_OFFSET):
        rows, contents = table.contents(command, layout, 0)
        target[rows] = contents["counts"]
    return {
        "position": drive.to_position(raw["position"]),
        "command": drive.to_position(target),
        "voltage": raw["voltage"] * drive.voltage.scale * drive.sign,
        "effort": raw["torque"] * pdo.effort_per_count(rig, joint),
        "statusword": np.nan_to_num(raw["status"]).astype(np.int64),
        "error_code": table.latest(0x80 + drive.node_id, lambda data: emcy.decode(data).code),
    }


def _repeat(
    rig: Rig, joints: dict[str, NDArray[Any]], motion: Motion | None
) -> tuple[Ints, float, Trajectory | None]:
    """Repetition index of each sample (n,), the period [samples], and the trajectory if it was commanded."""
    command, n = joints["command"], len(joints["command"])
    cycles = find_cycles(command if np.isfinite(command).any() else joints["position"])
    # Lost SYNCs may hide the repetitions: then it has its usual number of cycles, or was not commanded.
    for trajectory in map(motion, (cycles.count if cycles else 1, None)) if motion else ():
        if (first := _locate(rig, command, trajectory)) is not None:
            repeat = np.full(n, -1)
            repeat[first : first + len(trajectory.repeat)] = trajectory.repeat
            return repeat, trajectory.period * trajectory.rate, trajectory
    if cycles:
        return cycles.repeat(n), cycles.period, None
    enabled = (joints["statusword"] & _STATE_BITS) == cia402.STATUS_BITS[cia402.DriveState.ENABLED]
    return np.where(enabled.all(axis=1), 0, -1), 0.0, None


def _locate(rig: Rig, command: Floats, trajectory: Trajectory) -> int | None:
    """Find the row of `command` (n, dof) at which `trajectory` begins; None if it was not commanded."""
    path = trajectory.joint_position
    offset_count = len(command) - len(path) + 1
    if offset_count < 1:
        return None
    # Neighbouring samples differ most where the motion is fast.
    speed = np.abs(trajectory.joint_velocity).sum(axis=1)
    anchors = [segment[np.argmax(speed[segment])] for segment in np.array_split(np.arange(len(path)), _ANCHOR_COUNT)]
    one_count = np.array([1 / abs(drive.counts_per_radian) for drive in rig.drives])
    votes = np.zeros(offset_count, np.int64)
    for anchor in anchors:
        votes += (np.abs(command[anchor : anchor + offset_count] - path[anchor]) < one_count).all(axis=1)
    best = int(np.argmax(votes))
    return best if votes[best] >= _MIN_AGREEMENT * len(anchors) else None


def _is_simulated(frames: NDArray[Any], rig: Rig) -> bool:
    """Whether the segments of an SDO upload contain the device name of a simulated drive."""
    answers = (frames["data"][frames["id"] == 0x580 + drive.node_id] for drive in rig.drives)
    return any(_SIMULATED_NAME in np.ascontiguousarray(answer[:, 1:]).tobytes() for answer in answers)

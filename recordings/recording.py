"""Contents of a recording as arrays: the input of all later stages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recordings.config import ConfigSection
from recordings.files import sha256
from recordings.notebook import html_table
from recordings.pickling import WithoutCaches
from recordings.rig import Rig
from recordings.schemas import Level
from recordings.urdf import Vector

if TYPE_CHECKING:
    import pandas

Pace = Literal["lockstep", "realtime"]
"""Time is simulated and advances with SYNC, or it is the host's."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Words = NDArray[np.uint16]
"""16-bit words as the drives send them; they take a quarter of the memory of floats."""
_MAX_STEP = 1.5
"""Rows are lost where the time between two is longer than this many cycles."""


def lateness_quantiles(lateness: Floats) -> dict[str, float]:
    """Median, 99 % quantile and largest of the lateness (n,) of cycles or frames [s], as all documents name them."""
    return dict(zip(("p50", "p99", "max"), np.quantile(lateness, (0.5, 0.99, 1.0)).tolist(), strict=True))


class Run(ConfigSection):
    """One run: the metadata record `run` of a recording."""

    trajectory: str
    trajectory_digest: str
    period: float
    """Duration of one repetition of the motion [s]; 0 where the motion does not repeat."""
    cycles: int
    """Repetitions of the motion."""
    rate: float
    """SYNCs per second [Hz]."""
    software: str
    simulated: bool
    pace: Pace
    feedforward: str | None = None
    """SHA-256 of the model, or the table, whose torque was fed forward; None: no feed-forward."""
    torque_age: float | None = None
    """By how much the reported torque is older than the position of the same sample [s]; None: not known."""
    torque_window: float | None = None
    """Time over which a reported torque is averaged [s]; None: from one sample to the next."""
    seed: int | None = None
    """Seed of the noise of the simulated rig; None where no random numbers were drawn."""
    start: str
    """ISO 8601 time of the first SYNC; the epoch in lockstep, where time is simulated."""
    robot: str | None = None
    """Name of the robot, where it is not that of the rig."""
    exit_status: int | None = None
    """0 done, 1 failed, 3 stopped by an alarm, None interrupted."""
    reason: str | None = None
    """Reason for the end of the run."""

    @property
    def drives_in_words(self) -> str:
        """Whether a real robot moved, where that is known."""
        if self.simulated:
            return "simulated: no real robot moved"
        return _NOT_KNOWN.get(self.trajectory, "real")

    @property
    def start_in_words(self) -> str:
        """When it began, where a clock said so."""
        if not self.start.startswith("1970-01-01"):
            return self.start
        return "in simulated time" if self.simulated else "not known"


IMPORTED = "imported"
"""Name of the trajectory of a recording that another program measured."""
LOST = "unknown"
"""Name of the trajectory where the record of the run is lost."""
_NOT_KNOWN = {
    IMPORTED: "not known: imported, and not said to be simulated",
    LOST: "not known: the record of the run is lost",
}


@dataclass(frozen=True)
class LoggedEvent:
    """One line of `/events`."""

    time: float
    """Host time from the first SYNC [s]."""
    level: Level
    source: str
    message: str


@dataclass(frozen=True, eq=False, repr=False)
class Recording(WithoutCaches):
    """Recording of n SYNC cycles of a mechanism with dof joints. NaN marks a gap: a sample that was not received."""

    path: Path
    rig: Rig
    run: Run
    time: Floats
    """(n,) SYNC instants from the first one [s]; imported samples need not be evenly spaced."""
    position: Floats
    """(n, dof) measured joint position at the SYNC [rad]."""
    command: Floats
    """(n, dof) reference sent for this SYNC [rad]."""
    voltage: Floats
    """(n, dof) signed operating voltage [V]."""
    velocity: Floats | None
    """(n, dof) [rad/s], only if the drives measure it."""
    effort: Floats | None
    """(n, dof) torque actual (object 6077) [N m], only if the drives measure it."""
    statusword: Words
    """(n, dof)."""
    error_code: Words
    """(n, dof)."""
    repeat: Ints
    """(n,) repetition of the motion, 0 to cycles - 1; -1 during approach and stop."""
    lateness: Floats
    """(n,) delay with which the host began the cycle [s]."""
    events: tuple[LoggedEvent, ...]
    extra: Mapping[str, Floats] = field(default_factory=dict)
    """Further values (n,) by name, imported with the samples."""
    beyond: tuple[tuple[float, Vector], ...] = ()
    """Masses [kg], NaN for an unknown one, and their places [m] that it carries beyond the payload of its rig."""
    known_digest: str | None = None
    """SHA-256 of what the recording was made of; None: that of the file `path`."""

    @classmethod
    def from_arrays(
        cls,
        time: ArrayLike,
        position: ArrayLike,
        *,
        effort: ArrayLike | None = None,
        voltage: ArrayLike | None = None,
        current: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        command: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
        cycle: ArrayLike | None = None,
        rig: str | Path | Rig | None = None,
    ) -> Recording:
        """Make a recording of measurements in memory: arrays (n, dof), or (n,) of one joint; NaN is a gap.

        time: (n,) [s], increasing, need not be even.
        position, velocity, command: [rad] and [rad/s], or [m] and [m/s] of a prismatic joint.
        effort, voltage, current: exactly one of them, in [N m] or [N], [V], [A].
        temperature: of the drives [degC].
        cycle: (n,) number of the repetition; None: repetitions are found from the motion.
        rig: description of the machine or its file; None: the delta robot of the paper, which has three joints.

        Raises:
            BadInput: shapes do not fit, not one quantity tells the torque, or a value cannot be.
            TypeError: an argument is no array of real numbers, or no rig.
        """
        from recordings.importing.in_memory import of_arrays

        torque = {"effort": effort, "voltage": voltage, "current": current}
        others = {"velocity": velocity, "command": command, "temperature": temperature}
        return of_arrays(time, position, cycle, rig, **torque, **others)

    @classmethod
    def from_frame(
        cls, frame: pandas.DataFrame, *, map: Mapping[str, str] | None = None, rig: str | Path | Rig | None = None
    ) -> Recording:
        """Make a recording of a data frame with the columns of CSV import, as `to_frame` gives them.

        map: the column and unit of a quantity, as {"effort_1": "i1:A*0.12"}, where it has another name.
        rig: as in `from_arrays`.

        Raises:
            BadInput: a column is missing, or a value cannot be.
            TypeError: `frame` is no data frame, or an argument has another type.
        """
        from recordings.importing.in_memory import of_columns

        if not hasattr(frame, "columns"):
            raise TypeError(f"frame: a data frame expected, {type(frame).__name__} found")
        return of_columns("frame", {str(name): frame[name].to_numpy() for name in frame.columns}, map, rig)

    def to_frame(self) -> pandas.DataFrame:
        """The samples as a data frame with the columns of CSV import.

        Raises:
            BadInput: pandas is not installed.
        """
        from recordings.columns import columns
        from recordings.frames import data_frame

        return data_frame(columns(self))

    def plot(self) -> Any:
        """A Plotly figure of position, following error and drive signal of all joints over time."""
        from ident.output.figures.quality import motion

        return motion(self)

    def __repr__(self) -> str:
        """One line: what was recorded."""
        machine = f"{self.rig.name}, {self.rig.dof} joints"
        return f"<Recording {self.path.name}: {machine}, {len(self.time)} samples in {np.ptp(self.time):.4g} s>"

    def _repr_html_(self) -> str:
        """The same, and a table of what was measured, for a notebook."""
        from recordings.columns import columns

        measured = {name: values for name, values in columns(self).items() if np.isfinite(values).any()}
        rows = [(name, f"{np.nanmin(values):.4g}", f"{np.nanmax(values):.4g}") for name, values in measured.items()]
        return html_table(repr(self), ("column", "smallest", "largest"), rows)

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the digest as well: the file may not be where the recording is unpickled."""
        known = self.known_digest or self.path.is_file()
        return {**super().__getstate__(), "known_digest": self.digest if known else None}

    @property
    def digest(self) -> str:
        """SHA-256 of the file, or of what the recording was made of."""
        return self.known_digest or sha256(self.path)

    @property
    def complete(self) -> bool:
        """False where the recording was interrupted."""
        return self.run.exit_status is not None

    @property
    def temperature(self) -> Floats:
        """(n, dof) temperature of the drives [degC]; NaN where it was not measured."""
        return self.numbered("temperature")

    def numbered(self, name: str) -> Floats:
        """Further values (n, dof) NAME_1 ... NAME_n, one per joint; NaN for a joint without them."""
        none = np.full(len(self.time), np.nan)
        return np.column_stack([self.extra.get(f"{name}_{joint}", none) for joint in range(1, self.rig.dof + 1)])

    @cached_property
    def following_error(self) -> Floats:
        """(n, dof) target minus measured position [rad or m]; NaN without a command or an answer.

        The answers at a SYNC show how the target of the cycle before was reached, and the last one that was sent
        stays the target while the host misses cycles. In an imported recording both are of the same instant.
        """
        target = self.command
        if self.run.trajectory != IMPORTED:
            rows = np.where(np.isfinite(self.command), np.arange(len(self.command))[:, None], 0)
            target = np.take_along_axis(self.command, np.maximum.accumulate(rows, axis=0), axis=0)
            target = np.concatenate([np.full((1, target.shape[1]), np.nan), target[:-1]])
            target[1:][self._gaps_in_time > 0] = np.nan
        return np.where(np.isfinite(self.command), target - self.position, np.nan)

    @property
    def gaps(self) -> Ints:
        """Number of lost samples per joint (dof,)."""
        return np.isnan(self.position).sum(axis=0, dtype=np.int64)

    @property
    def longest_gap(self) -> float:
        """Longest time without any row [s]; 0 where none is lost."""
        return float(self._gaps_in_time.max(initial=0.0))

    @property
    def _gaps_in_time(self) -> Floats:
        """(n - 1,) time between two rows [s]; 0 where no row is lost between them."""
        steps = np.diff(self.time)
        return np.where(steps > _MAX_STEP / self.run.rate, steps, 0.0)


@dataclass(frozen=True, eq=False)
class CanFrames:
    """The n frames of a recording in the order in which they were logged."""

    stamp: Ints
    """(n,) timestamp of each frame [ns]."""
    log: Ints
    """(n,) arrival time at the host [ns]."""
    id: Ints
    """(n,) arbitration id."""
    dlc: Ints
    """(n,) number of data bytes."""
    data: NDArray[np.uint8]
    """(n, 8) data bytes, zero beyond dlc."""
    sent: Bools
    """(n,) True for sent frames, False for received ones."""
    rtr: Bools
    extended: Bools
    error: Bools

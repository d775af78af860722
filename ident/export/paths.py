"""Paths for which a model computes the torque: a trajectory, a table of positions, or a recording."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ident.basics import slicing
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.motion import Motion
from ident.estimation.chunks import CHUNK_LENGTH, RUN_IN, overlapping_chunks
from ident.estimation.predicted_torque import TorquePredictor
from ident.identification.model_file import ModelFile
from ident.identification.prediction import check_model_rig
from recordings.csv_table import read_table
from recordings.errors import BadInput
from recordings.importing.table import Table
from recordings.reader import Source, opened
from recordings.recording import Floats
from recordings.rig import Limits, Rig
from trajectories import kinematics, library
from trajectories.kinematics import Unreachable

RUN_OUT = 0.1
"""Time behind a chunk that a delay may look ahead [s]."""
REST_SPEED = 1e-5
"""Speed below which a joint of a path that is given by positions is at rest [rad/s or m/s]: rounding of the positions
must not switch dry friction on."""
CHUNK_ROWS = 16_000
"""Rows of a given path that are evaluated at a time: their arrays are small enough to be used again and again."""
EXCERPT = 5000
"""Instants of an excerpt of a long path."""
MIN_ROWS = 6
"""Fewest rows of a path that is given by positions: those of one quintic polynomial."""
MAX_UNEVENNESS = 0.01
"""Largest deviation of a time step from the mean one, relative: rounding of the times."""


@dataclass(frozen=True, eq=False)
class PathChunk:
    """Consecutive rows of a path, with those around them that effects with a memory need."""

    time: Floats
    """(n,) [s]."""
    motion: Motion
    """(n, dof) as encoders report it."""
    inputs_of: Callable[[InverseDynamics], EffectInputs]
    """Computes the inputs of effects for a model."""
    used: slice
    """Rows that belong to the chunk."""


@dataclass(frozen=True, eq=False)
class GivenPath:
    """A path that is evenly sampled at n instants, and known exactly."""

    name: str
    rate: float
    """Instants per second [Hz]."""
    time: Floats
    """(n,) [s]."""
    motion: Motion
    """(n, dof)"""
    temperature: Floats | None = None
    """(n, dof) of the drives [degC]; None where it is not known."""
    limits: Limits = field(default_factory=Limits)

    def chunks(self) -> Iterator[PathChunk]:
        """Yield overlapping chunks: the state of effects is settled after RUN_IN."""
        before, after = int(RUN_IN * self.rate), int(RUN_OUT * self.rate)
        for first in range(0, len(self.time), CHUNK_ROWS):
            start = max(0, first - before)
            yield self._chunk(
                slice(start, first + CHUNK_ROWS + after), slice(first - start, first - start + CHUNK_ROWS)
            )

    def excerpt(self) -> PathChunk:
        """Return the middle of the path."""
        start = max(0, (len(self.time) - EXCERPT) // 2)
        return self._chunk(slice(start, start + EXCERPT), slice(None))

    def _chunk(self, rows: slice, used: slice) -> PathChunk:
        time, motion = self.time[rows], slicing.along_time(self.motion, rows)
        temperature = None if self.temperature is None else self.temperature[rows]
        end = float(self.time[-1])
        return PathChunk(
            time, motion, lambda model: model.inputs(motion, 1 / self.rate, time, temperature, end), used
        )

    def at_temperature(self, celsius: float | None) -> "GivenPath":
        """Return the path with drives of one temperature [degC]; unchanged for None."""
        if celsius is None:
            return self
        return replace(self, temperature=np.full_like(self.motion.position, celsius))


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """The motion of a recording, preprocessed as for the fit of the model."""

    prepared: PreparedRecording

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.prepared.recording.path.name

    @property
    def rate(self) -> float:
        """Instants per second [Hz]."""
        return self.prepared.samples.rate

    @property
    def limits(self) -> Limits:
        """Of the rig of the recording."""
        return self.prepared.recording.rig.limits

    def chunks(self) -> Iterator[PathChunk]:
        """Yield chunks as `ident compare` evaluates them."""
        step = self.prepared.preprocessed.decimation
        for prepared, rows in overlapping_chunks(self.prepared):
            used = rows if rows.stop is None else slice(rows.start * step, rows.stop * step)
            yield _recorded_chunk(prepared, used)

    def excerpt(self) -> PathChunk:
        """Return the first chunk."""
        return next(self.chunks())


TorquePath = GivenPath | RecordedPath
"""A path whose torque is wanted: its `name`, its `rate` [Hz], the `limits` of the machine that moves along it, the
`chunks` that follow each other, and an `excerpt` that stands for the whole where much is computed."""


def _recorded_chunk(prepared: PreparedRecording, used: slice) -> PathChunk:
    predictor = TorquePredictor(prepared)
    return PathChunk(
        prepared.instant_time,
        prepared.preprocessed.motion,
        lambda model: predictor.effect_inputs(model.structure, model.values),
        used,
    )


def from_trajectory(name: str, rig: Rig, cycles: int | None = None, rate: float | None = None) -> GivenPath:
    """The trajectory `name`, or that of a file, as `daq record --traj` streams it to `rig`.

    Raises:
        BadInput: the trajectory is unknown or invalid, or out of reach.
    """
    trajectory = library.load(name, rig, cycles, rate)
    velocity = trajectory.joint_velocity
    motion = Motion(trajectory.joint_position, velocity, trajectory.joint_acceleration, np.sign(velocity))
    return GivenPath(trajectory.name, trajectory.rate, trajectory.time, motion, limits=rig.limits)


def from_table(path: Path, rig: Rig) -> GivenPath:
    """The path in a CSV file: `time`, and `position_i` of the joints (or `joint_i`) or `x`, `y`, `z` of the platform.

    Velocity and acceleration of the joints are those in the columns `velocity_i` and `acceleration_i`, else the
    derivatives of a quintic spline through the positions. `temperature_i` [degC] is optional.

    Raises:
        BadInput: the file is not such a table, time is not even, or a position is out of reach.
    """
    table = read_table(path)
    time, rate = _even_time(table)
    position = _positions(table, rig)
    _check_reach(table, rig, position)
    velocity, acceleration = (_numbered(table, name, rig.dof) for name in ("velocity", "acceleration"))
    if velocity is None or acceleration is None:
        velocity, acceleration = _derivatives(position, rate)
    motion = Motion(position, velocity, acceleration, np.sign(velocity))
    return GivenPath(path.name, rate, time, motion, _numbered(table, "temperature", rig.dof))


def from_recording(source: Source, model: ModelFile) -> RecordedPath:
    """The motion of the recording `source`, preprocessed as the training data of `model`.

    Raises:
        BadInput: the recording cannot be used, or is of another rig than the model.
    """
    recording = opened(source)
    check_model_rig(model, recording)
    cutoff = model.preprocessing.bandwidth if model.preprocessing.cutoff else None
    return RecordedPath(prepare(recording, model.preprocessing.name, cutoff, form=model.form))


def _even_time(table: Table) -> tuple[Floats, float]:
    """Time (n,) [s], and the rate [Hz]."""
    if "time" not in table.columns:
        raise BadInput(f"{table.path}: a column 'time' [s] expected, {', '.join(table.columns)[:60]} found; add it")
    time = table.columns["time"]
    if len(time) < MIN_ROWS or np.isnan(time).any():
        raise BadInput(f"{table.path}: at least {MIN_ROWS} rows, each with a time, expected; add what is missing")
    step = (time[-1] - time[0]) / (len(time) - 1)
    uneven = np.abs(np.diff(time) - step) > MAX_UNEVENNESS * abs(step)
    if not step > 0 or uneven.any():
        row = int(np.argmax(uneven)) + 1
        raise BadInput(
            f"{table.location(row, 'time')}: even steps expected, {time[row] - time[row - 1]:g} s behind steps of "
            f"{step:g} s found; sample the path evenly, or give points with --traj"
        )
    return time, float(1 / step)


def _positions(table: Table, rig: Rig) -> Floats:
    """Joint positions (n, dof) [rad or m]."""
    for name in ("position", "joint"):
        position = _numbered(table, name, rig.dof)
        if position is not None:
            return position
    if rig.mechanism == "delta" and all(name in table.columns for name in "xyz"):
        try:
            return kinematics.inverse(rig.geometry, np.column_stack([_complete(table, name) for name in "xyz"]))
        except Unreachable as error:
            raise error.at(table.location(error.row)) from None
    platform = " or x, y, z [m]" if rig.mechanism == "delta" else ""
    raise BadInput(
        f"{table.path}, line 1: columns position_1 ... position_{rig.dof}{platform} expected, "
        f"{', '.join(table.columns)[:60]} found; rename them"
    )


def _numbered(table: Table, name: str, dof: int) -> Floats | None:
    """Columns name_1 ... name_n as (n, dof); None unless all are there."""
    names = [f"{name}_{joint}" for joint in range(1, dof + 1)]
    if not all(each in table.columns for each in names):
        return None
    return np.column_stack([_complete(table, each) for each in names])


def _complete(table: Table, name: str) -> Floats:
    column = table.columns[name]
    if np.isnan(column).any():
        location = table.location(int(np.argmax(np.isnan(column))), name)
        raise BadInput(f"{location}: a number expected, a gap found; a path has no gaps")
    return column


def _check_reach(table: Table, rig: Rig, position: Floats) -> None:
    """Say at once, and with its line, where a path tears the mechanism apart."""
    if rig.mechanism != "delta":
        return
    for first in range(0, len(position), CHUNK_LENGTH):  # small arrays stay in the processor's cache
        try:
            kinematics.forward(rig.geometry, position[first : first + CHUNK_LENGTH])
        except Unreachable as error:
            raise error.at(table.location(first + error.row)) from None


def _derivatives(position: Floats, rate: float) -> tuple[Floats, Floats]:
    """Velocity and acceleration (n, dof) of the quintic spline through `position` (n, dof)."""
    from scipy.interpolate import make_interp_spline

    number = np.arange(len(position), dtype=float)
    spline = make_interp_spline(number, position, k=5)
    velocity, acceleration = rate * spline(number, 1), rate**2 * spline(number, 2)
    velocity[np.abs(velocity) < REST_SPEED] = 0.0
    return velocity, acceleration

"""Where the torque of a feed-forward comes from: a model, by the program `ident`, or a table."""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from daq.feedforward.torque_table import TorqueTable, read_torque_table
from daq.ident_program import IDENT
from recordings.errors import BadInput
from recordings.files import sha256
from recordings.limits import json_object
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory

_TRIAL_ROWS = 20
"""Rows of a trajectory on which a model is tried."""
_STREAM, _TABLE = "stream.csv", "torque.csv"


@dataclass(frozen=True, eq=False)
class PlannedTorque:
    """Torque (n, dof) [N m] of each target of a run."""

    approach: Floats | None
    """None: not known, so that the approach has no offset."""
    stream: Floats
    table_digest: str
    """SHA-256 of the table that it was read from."""


class TorqueSource(Protocol):
    """Source of a feed-forward's torque."""

    @property
    def path(self) -> Path:
        """The file that was given."""

    @property
    def digest(self) -> str:
        """Its SHA-256."""

    def compute(self, start: float, approach: Floats, trajectory: Trajectory) -> PlannedTorque:
        """Compute the torque of the approach (m, dof) [rad] and of the trajectory.

        The approach begins `start` [s] after the first SYNC. It may take seconds; another thread may cancel it.

        Raises:
            BadInput: it cannot be computed, or it is none of this rig and motion.
        """

    def cancel(self) -> None:
        """End the computation; without effect where there is none."""


def open_source(path: Path, rig: Rig, rig_file: Path | None, trajectory: Trajectory) -> TorqueSource:
    """The model, or the table, in the file `path`.

    A model is tried on the beginning of the trajectory, so that what `ident torque` refuses is refused at once.

    Raises:
        BadInput: the file cannot be read, a table is not of this trajectory, or a model is refused.
    """
    if path.suffix.lower() == ".csv":
        return _GivenTable(path, read_torque_table(path, rig), trajectory)
    model = _Model(path, rig, rig_file)
    model.compute_table(0.0, trajectory.joint_position[:_TRIAL_ROWS])
    return model


class _GivenTable:
    """A table over the trajectory; the approach has no offset."""

    def __init__(self, path: Path, table: TorqueTable, trajectory: Trajectory) -> None:
        self.path, self.digest = path, table.digest
        self._torque = table.along(trajectory.time, trajectory.joint_position)

    def compute(self, start: float, approach: Floats, trajectory: Trajectory) -> PlannedTorque:
        """See `TorqueSource`."""
        return PlannedTorque(None, self._torque, self.digest)

    def cancel(self) -> None:
        """See `TorqueSource`."""


class _Model:
    """A model, whose torque `ident torque` computes in a process of its own."""

    def __init__(self, path: Path, rig: Rig, rig_file: Path | None) -> None:
        self.path = path
        self._rig, self._rig_file = rig, rig_file
        self._process: subprocess.Popen[bytes] | None = None
        self._cancelled = False
        json_object(path, "--feedforward: a model file (or table .csv)")
        self.digest = sha256(path)

    def compute(self, start: float, approach: Floats, trajectory: Trajectory) -> PlannedTorque:
        """See `TorqueSource`."""
        table = self.compute_table(start, np.concatenate([approach, trajectory.joint_position]))
        split = len(approach)
        return PlannedTorque(table.torque[:split], table.torque[split:], table.digest)

    def compute_table(self, start: float, rows: Floats) -> TorqueTable:
        """Compute the torque at the joint positions `rows` (n, dof) [rad], of which the first is at `start` [s].

        Raises:
            BadInput: `ident torque` refuses.
        """
        with tempfile.TemporaryDirectory(prefix="feedforward-") as name:
            folder = Path(name)
            self._write_stream(folder / _STREAM, start, rows)
            reason = self._run(folder)
            if reason is not None:
                raise BadInput(f"--feedforward {self.path}: {reason}")
            return read_torque_table(folder / _TABLE, self._rig)

    def _write_stream(self, path: Path, start: float, rows: Floats) -> None:
        time = start + np.arange(len(rows)) / self._rig.rate
        header = ",".join(["time", *(f"position_{joint}" for joint in range(1, self._rig.dof + 1))])
        np.savetxt(path, np.column_stack([time, rows]), "%.12g", ",", header=header, comments="")

    def _run(self, folder: Path) -> str | None:
        """Run `ident torque`; returns the reason where it fails."""
        rig_file = self._rig_file
        if rig_file is None:
            # Every key that is not named has the value of the simulated rig.
            rig_file = folder / "rig.toml"
            rig_file.write_text(f"name = {json.dumps(self._rig.name)}\n")
        files = ["--csv", folder / _STREAM, "--rig", rig_file, "-o", folder / _TABLE]
        with (folder / "errors").open("w+") as errors:
            self._process = subprocess.Popen(
                [*IDENT, "torque", str(self.path), *map(str, files)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                # Ctrl-C in the terminal is for this program, which then ends the process.
                start_new_session=True,
            )
            if self._cancelled:
                self._process.kill()
            try:
                status = self._process.wait()
            except BaseException:
                self._process.kill()
                raise
            if status == 0:
                return None
            errors.seek(0)
            lines = [line.strip() for line in errors if line.strip()]
        return lines[-1].removeprefix("error: ") if lines else "`ident torque` ended without a reason"

    def cancel(self) -> None:
        """See `TorqueSource`."""
        self._cancelled = True
        if self._process is not None:
            self._process.kill()

"""The torque of a path by its causes: a table of columns, computed in chunks, and the RMS of each cause."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ident.dynamics.torque_map import voltage_from_torque
from ident.export.paths import PathChunk, TorquePath
from ident.identification.model import Model
from recordings.recording import Floats

Columns = dict[str, Floats]
"""Columns (n,) by name."""


@dataclass(eq=False)
class TorqueSummary:
    """RMS of the torque and of its causes along a path, summed up chunk by chunk."""

    squares: dict[str, Floats] = field(default_factory=dict)
    """Sum of squares (dof,) by cause; "torque": of all of them."""
    count: Floats = field(default_factory=lambda: np.zeros(1))
    """(dof,) rows."""

    def add(self, torque: Floats, terms: dict[str, Floats]) -> None:
        """Take in the next rows, (n, dof) each; rows with NaN do not count."""
        known = np.isfinite(torque)
        self.count = self.count + known.sum(axis=0)
        for name, values in {"torque": torque, **terms}.items():
            self.squares[name] = self.squares.get(name, 0.0) + (np.where(known, values, 0.0) ** 2).sum(axis=0)

    @property
    def rms(self) -> dict[str, Floats]:
        """RMS (dof,) of each cause [N m or N]."""
        return {
            name: np.sqrt(total / np.maximum(self.count, 1))
            for name, total in self.squares.items()
            if name != "torque"
        }

    @property
    def torque_rms(self) -> Floats:
        """RMS (dof,) of the torque [N m or N]."""
        return np.sqrt(self.squares["torque"] / np.maximum(self.count, 1))

    @property
    def share(self) -> dict[str, Floats]:
        """RMS (dof,) of each cause over that of the torque. Causes that oppose each other exceed 1 together."""
        whole = self.torque_rms
        return {name: rms / np.where(whole > 0, whole, 1.0) for name, rms in self.rms.items()}


def tables(model: Model, path: TorquePath, summary: TorqueSummary) -> Iterator[Columns]:
    """Yield the columns of `path` chunk by chunk, and sum them up in `summary`.

    time [s], position_i, velocity_i, acceleration_i, torque_i, voltage_i, and CAUSE_i for every cause; NaN where the
    motion is not known.

    Raises:
        BadInput: an effect needs what the path does not have, or the path is out of reach.
    """
    for chunk in path.chunks():
        torque, terms = evaluate(model, chunk)
        summary.add(torque, terms)
        motion, used = chunk.motion, chunk.used
        signals = {
            "position": motion.position[used],
            "velocity": motion.velocity[used],
            "acceleration": motion.acceleration[used],
            "torque": torque,
            "voltage": _voltage(model, chunk, torque),
            **terms,
        }
        yield {"time": chunk.time[used]} | {
            f"{name}_{joint}": np.ascontiguousarray(column)
            for name, signal in signals.items()
            for joint, column in enumerate(signal.T, start=1)
        }


def evaluate(model: Model, chunk: PathChunk) -> tuple[Floats, dict[str, Floats]]:
    """Torque (n, dof) [N m or N] in the used rows of `chunk`, and its terms."""
    terms = {
        name: values[chunk.used] for name, values in model.dynamics.terms_with_corrections(chunk.inputs_of).items()
    }
    return np.sum(list(terms.values()), axis=0), terms


def _voltage(model: Model, chunk: PathChunk, torque: Floats) -> Floats:
    """Voltage (n, dof) [V] that the drives report with the `torque` (n, dof) in the used rows of `chunk`."""
    dynamics = model.dynamics
    inputs = chunk.inputs_of(dynamics)
    reported = dynamics.reported(inputs)[chunk.used] if dynamics.distorts_report else torque
    return voltage_from_torque(reported, inputs.rig.torque)  # a recording may have other gains than the model's

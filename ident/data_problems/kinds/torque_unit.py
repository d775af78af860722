"""Efforts in another unit than N m or N, off by a power of ten, where a reference model tells their size."""

from collections.abc import Sequence

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import holds_torque
from ident.data_problems.facts import Facts
from recordings.command_line import repeated
from recordings.data_problems import DataProblem, healing_command
from recordings.data_problems.signals import drive_signal

_MIN_POWER = 2
"""A friction that the reference leaves out may be as large as the rest, and a gear may be ten."""
_MAX_LEFT = 0.5
"""Share of the torque that reference and friction may leave; beyond, the reference says nothing."""


def find(facts: Facts) -> DataProblem | None:
    """Return the problem if all efforts are hundred times as large as the reference, or a hundredth of it."""
    recording = facts.recordings[0].recording
    if not holds_torque(recording) or any(each.nominal is None for each in facts.recordings):
        return None
    scale, left = _scale(facts.recordings)
    power = round(np.log10(scale)) if scale > 0 else 0
    if abs(power) < _MIN_POWER or left > _MAX_LEFT:
        return None
    units = recording.rig.effort_units
    name = drive_signal(recording)[0]
    mapped = [f"{name}_{j}={name}_{j}:{unit.replace(' ', '')}*1e{-power}" for j, unit in enumerate(units, 1)]
    return DataProblem(
        kind="torque-unit",
        joints=(),
        blocks=True,
        why=f"The efforts are {scale:.2g} times those of the manufacturer's model: their unit is off by 10^{power}.",
        remedy=healing_command(recording.path, repeated("--map", mapped)),
    )


def _scale(recordings: Sequence[PreparedRecording]) -> tuple[float, float]:
    """What the reference is to be multiplied by, beside friction, and the RMS share of the torque that is left."""
    friction = [parameter.friction for parameter in recordings[0].mechanism.parameters]
    columns = np.concatenate(
        [
            np.concatenate([each.nominal[:, :, None], each.regressor[:, :, friction]], 2)
            for each in recordings
            if each.nominal is not None
        ]
    )
    torque = np.concatenate([each.torque for each in recordings])
    known = np.isfinite(torque) & np.isfinite(columns).all(axis=2)
    columns, torque = columns[known], torque[known]
    solution = np.linalg.lstsq(columns, torque, rcond=None)[0]
    left = torque - columns @ solution
    return float(solution[0]), float(np.sqrt((left @ left) / (torque @ torque)))

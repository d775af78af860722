"""Efforts in another unit than N m or N, off by a power of ten, where the manufacturer's model says how large they are."""

import numpy as np

from ident.data.samples import holds_torque
from ident.data_problems.facts import Facts
from recordings.data_problems import DataProblem, healing_command
from recordings.data_problems.signals import drive_signal

_MIN_POWER = 2
"""A friction that the reference leaves out may be as large as the rest, and a gear may be ten."""
_MIN_CORRELATION = 0.7
"""Correlation with the reference below which it says nothing."""


def find(facts: Facts) -> DataProblem | None:
    """Return the problem if all efforts are hundred times as large as the reference, or a hundredth of it."""
    recording = facts.recordings[0].recording
    if not holds_torque(recording) or any(each.nominal is None for each in facts.recordings):
        return None
    torque, nominal = (
        np.concatenate([values.ravel() for values in each])
        for each in ([r.torque for r in facts.recordings], [r.nominal for r in facts.recordings])
    )
    known = np.isfinite(torque) & np.isfinite(nominal)
    torque, nominal = torque[known], nominal[known]
    scale = float(torque @ nominal / (nominal @ nominal))
    correlation = float(torque @ nominal / np.sqrt((torque @ torque) * (nominal @ nominal)))
    power = round(np.log10(scale)) if scale > 0 else 0
    if abs(power) < _MIN_POWER or correlation < _MIN_CORRELATION:
        return None
    units = recording.rig.effort_units
    name = drive_signal(recording)[0]
    mapped = [f"{name}_{j}={name}_{j}:{unit.replace(' ', '')}*1e{-power}" for j, unit in enumerate(units, 1)]
    return DataProblem(
        kind="torque-unit",
        joints=(),
        blocks=True,
        why=f"The efforts are {scale:.2g} times those of the manufacturer's model: their unit is off by 10^{power}.",
        remedy=healing_command(recording.path, [word for entry in mapped for word in ("--map", entry)]),
    )

"""Samples that are held: a slower program or bus repeats its last value until it has a new one."""

import numpy as np

from recordings.data_problems import DataProblem, healing_command
from recordings.data_problems.signals import drive_signal, moving
from recordings.recording import Bools, Floats, Recording
from recordings.resolution import resolution

LONGEST = 1 / 120
"""Values that change at least this often serve an analysis up to 30 Hz [s]: a quarter of its period."""
_REGULAR = 0.9
"""Samples are held if this share of the changes comes after the same number of samples, or a multiple of it."""
_STEPS = 3.0
"""Changes of a held signal are this many times its resolution; smaller ones are those of a slow motion."""
_MIN_CHANGES = 10


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if position or torque of a moving joint changes only at long intervals."""
    name, drive = drive_signal(recording)
    held: dict[tuple[str, int], int] = {}
    for joint in range(recording.rig.dof):
        rows = moving(recording, joint)
        for signal, values in (("position", recording.position), (name, drive)):
            if count := held_count(values[:, joint], rows, float(np.median(np.diff(recording.time)))):
                held[signal, joint + 1] = count
    if not held:
        return None
    longest, joints = max(held.values()), tuple(sorted({joint for _, joint in held}))
    names = ", ".join(f"{signal} {joint}" for signal, joint in held)
    return DataProblem(
        kind="held-samples",
        joints=joints,
        blocks=True,
        why=f"In motion, new values come only every {longest} samples ({names}).",
        remedy=healing_command(recording.path, ["--thin", str(longest)]),
    )


def held_count(values: Floats, rows: Bools, step: float) -> int:
    """Number of samples for which `values` (n,) are held in these `rows`; 0 where they are not.

    step: time between samples [s].
    """
    changed = np.flatnonzero(np.diff(values) != 0) + 1
    changed = changed[rows[changed] & np.isfinite(values[changed]) & np.isfinite(values[changed - 1])]
    if len(changed) < _MIN_CHANGES:
        return 0
    gaps = np.diff(changed)
    usual = int(np.median(gaps))
    sizes = np.abs(values[changed] - values[changed - 1])
    large = np.median(sizes) > _STEPS * (resolution(values) or 0.0)
    regular = np.mean(gaps % usual == 0) > _REGULAR
    return usual if usual > 1 and usual * step > LONGEST and regular and large else 0

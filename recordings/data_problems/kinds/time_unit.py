"""Time in another unit than seconds."""

import numpy as np

from recordings.data_problems import DataProblem, healing_command
from recordings.data_problems.signals import FASTEST, SLOWEST
from recordings.recording import Recording

_UNITS = (("ms", 1e3), ("us", 1e6), ("ns", 1e9), ("s*1000", 1e-3), ("s*1000000", 1e-6))


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if no motion is recorded at such a rate, and one would be in another unit."""
    steps = np.diff(recording.time)
    rate = 1 / float(np.median(steps[steps > 0])) if (steps > 0).any() else SLOWEST
    unit = next((unit for unit, factor in _UNITS if SLOWEST < rate * factor < FASTEST), None)
    if SLOWEST <= rate <= FASTEST or unit is None:
        return None
    return DataProblem(
        kind="time-unit",
        joints=(),
        blocks=True,
        why=f"A sample every {1 / rate:.4g} s is too {'slow' if rate < SLOWEST else 'fast'} for a motion: the time "
        f"looks like {unit}.",
        remedy=healing_command(recording.path, ["--map", f"time=time:{unit}"]),
    )

"""The range of a signal in the training rows, and the rows that are outside of it."""

from collections.abc import Sequence

import numpy as np

from recordings.recording import Bools, Floats

_MARGIN = 0.02
"""Share of the training range by which it may be exceeded."""


def training_range(signals: Sequence[Floats], train: Sequence[Bools]) -> tuple[Floats, Floats]:
    """Smallest and largest value (dof,) of the `signals` (m, dof) of all recordings in the `train` rows (m, dof).

    NaN where a joint has no training rows.
    """
    trained = np.concatenate([np.where(rows, signal, np.nan) for rows, signal in zip(train, signals, strict=True)])
    return np.fmin.reduce(trained), np.fmax.reduce(trained)


def outside_of_range(signals: Sequence[Floats], low: Floats, high: Floats) -> tuple[Bools, ...]:
    """(m, dof) rows of each recording at which the `signals` (m, dof) are below `low` or above `high` (dof,)."""
    margin = _MARGIN * (high - low)
    return tuple((signal < low - margin) | (signal > high + margin) for signal in signals)

"""Sensitivity of the parameters to assumptions: the length of the rods, the cut-off.

Refits are by least squares, whatever the estimator, because only changes of the parameters are needed. Only one
minute of long recordings is used.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ident.basics import slicing
from ident.data.prepared_recording import prepare
from ident.data.samples import grid
from ident.dynamics.structure import Term
from ident.estimation.regression import linearize
from recordings.errors import BadInput
from recordings.recording import Floats, Recording

_Refit = Callable[[Sequence[Recording], float | None], Floats]
"""Finds the parameters (k,) from recordings, at a cut-off [Hz]."""

LENGTH_STEP = 0.01
"""Change of the rods' length [m]."""
CUTOFF_FACTORS = (0.5, 2.0)
_MAX_DURATION = 60.0
"""Used duration of each recording [s]."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Changes of k parameters under other assumptions."""

    per_length_step: Floats | None
    """(k,) change of each, in its unit, if L2 is longer by LENGTH_STEP; None if the length cannot be changed."""
    per_cutoff: tuple[tuple[float, Floats], ...]
    """Other cut-offs [Hz] with the change (k,) of each, in its unit; empty if the preprocessing has no cut-off."""


def sensitivity(
    recordings: Sequence[Recording], method: str, cutoff: float | None, terms: tuple[Term, ...] = ()
) -> Sensitivity:
    """Refit `recordings`, preprocessed by `method` at `cutoff` [Hz] (None: no cut-off), with other assumptions.

    terms: effects of the model, all of them linear.
    """
    short = [_first_minute(recording) for recording in recordings]
    refit = partial(_refit, method=method, terms=terms)
    at_cutoff = tuple(_with_other_cutoffs(short, refit, cutoff)) if cutoff else ()
    return Sensitivity(_with_other_lengths(short, refit, cutoff), at_cutoff)


def _with_other_lengths(recordings: Sequence[Recording], refit: _Refit, cutoff: float | None) -> Floats | None:
    if recordings[0].rig.mechanism != "delta":
        return None
    try:
        shorter, longer = (
            refit([with_longer_rods(recording, step) for recording in recordings], cutoff)
            for step in (-LENGTH_STEP, LENGTH_STEP)
        )
    except BadInput:  # with the changed length, the mechanism cannot reach the recorded positions
        return None
    return (longer - shorter) / 2


def with_longer_rods(recording: Recording, step: float) -> Recording:
    """`recording` with rods longer by `step` [m]."""
    geometry = recording.rig.geometry
    longer = geometry.model_copy(update={"L2": geometry.L2 + step})
    return replace(recording, rig=recording.rig.model_copy(update={"geometry": longer}))


def _with_other_cutoffs(
    recordings: Sequence[Recording], refit: _Refit, cutoff: float
) -> Iterator[tuple[float, Floats]]:
    reference = refit(recordings, cutoff)
    highest = min(grid(recording)[0] for recording in recordings) / 5
    for factor in CUTOFF_FACTORS:
        changed = min(factor * cutoff, highest)
        if changed != cutoff:
            with suppress(BadInput):  # too few rows at that cut-off: it tells nothing
                yield changed, refit(recordings, changed) - reference


def _refit(recordings: Sequence[Recording], cutoff: float | None, *, method: str, terms: tuple[Term, ...]) -> Floats:
    prepared = [prepare(recording, method, cutoff) for recording in recordings]
    structures = [replace(each.base_structure, terms=terms) for each in prepared]
    rows, torques = zip(
        *(
            linearize(each, structure, np.zeros(len(structure.parameters))).rows()
            for each, structure in zip(prepared, structures, strict=True)
        ),
        strict=True,
    )
    return np.linalg.lstsq(np.concatenate(rows), np.concatenate(torques), rcond=None)[0]


def _first_minute(recording: Recording) -> Recording:
    """`recording` up to the end of the first minute of the repeated motion."""
    repeated = recording.time[recording.repeat >= 0] if (recording.repeat >= 0).any() else recording.time
    selected = recording.time <= repeated[0] + _MAX_DURATION
    return recording if selected.all() else slicing.along_time(recording, selected)

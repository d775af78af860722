"""How far the parameters move when what was assumed is a little different: the forearms' length, the cut-off.

By least squares, whatever the estimator: the question is how far the parameters move, not where they are. Long
recordings are looked at for a minute only.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ident.data.dataset import build
from ident.dynamics.mechanisms import Mechanism
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Rig

LENGTH_STEP = 0.01
"""Of the forearms [m]."""
CUTOFF_FACTORS = (0.5, 2.0)
_LONGEST = 60.0
"""Of each recording [s]."""

MechanismFactory = Callable[[Rig], Mechanism]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What happens to k parameters."""

    per_length_step: Floats | None
    """(k,) change of each, in its unit, where L2 is longer by LENGTH_STEP; None where it has no other."""
    per_cutoff: tuple[tuple[float, Floats], ...]
    """For other cut-offs [Hz]: change (k,) of each, in its unit; empty where the preprocessing has none."""


def sensitivity(recordings: Sequence[Recording], create: MechanismFactory, method: str, cutoff: float | None) -> Sensitivity:
    """Refit `recordings`, preprocessed by `method` at `cutoff` [Hz] (None: there is none), with other assumptions."""
    short = [_shortened(recording) for recording in recordings]
    at_cutoff = tuple(_with_other_cutoffs(short, create, method, cutoff)) if cutoff else ()
    return Sensitivity(_with_other_lengths(short, create, method, cutoff), at_cutoff)


def _with_other_lengths(
    recordings: Sequence[Recording], create: MechanismFactory, method: str, cutoff: float | None
) -> Floats | None:
    if recordings[0].rig.mechanism != "delta":
        return None
    try:
        shorter, longer = (
            _refit([with_longer_rods(recording, step) for recording in recordings], create, method, cutoff)
            for step in (-LENGTH_STEP, LENGTH_STEP)
        )
    except BadInput:  # with the other length, the mechanism cannot reach where it went
        return None
    change: Floats = (longer - shorter) / 2
    return change


def with_longer_rods(recording: Recording, step: float) -> Recording:
    """As if the forearms were longer by `step` [m]."""
    geometry = recording.rig.geometry
    longer = geometry.model_copy(update={"L2": geometry.L2 + step})
    return replace(recording, rig=recording.rig.model_copy(update={"geometry": longer}))


def _with_other_cutoffs(
    recordings: Sequence[Recording], create: MechanismFactory, method: str, cutoff: float
) -> Iterator[tuple[float, Floats]]:
    here = _refit(recordings, create, method, cutoff)
    highest = min(recording.run.rate for recording in recordings) / 5
    for factor in CUTOFF_FACTORS:
        other = min(factor * cutoff, highest)
        if other != cutoff:
            yield other, _refit(recordings, create, method, other) - here


def _refit(recordings: Sequence[Recording], create: MechanismFactory, method: str, cutoff: float | None) -> Floats:
    mechanism = create(recordings[0].rig)
    rows = [build(recording, mechanism, method, cutoff).rows() for recording in recordings]
    regressor, torque = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    parameters: Floats = np.linalg.lstsq(regressor, torque, rcond=None)[0]
    return parameters


def _shortened(recording: Recording) -> Recording:
    """The first minute of the repeated motion, with what comes before it."""
    repeated = recording.time[recording.repeat >= 0] if (recording.repeat >= 0).any() else recording.time
    kept = recording.time <= repeated[0] + _LONGEST
    if kept.all():
        return recording
    arrays = {
        field.name: value[kept]
        for field in fields(Recording)
        if isinstance(value := getattr(recording, field.name), np.ndarray) and len(value) == len(kept)
    }
    return replace(recording, **arrays)

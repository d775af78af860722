"""The worst intervals of a recording, and the phase of the motion in which they lie."""

from dataclasses import replace

import numpy as np

from ident.identification.prediction import Prediction
from ident.residuals.phases import phases
from ident.residuals.windows import worst_windows
from recordings.recording import Bools
from tests.ident import building


def prediction(where: Bools) -> Prediction:
    """A model that is wrong in the rows `where` (m,) of one joint."""
    prepared = building.prepared(building.record(noise=0.001))
    computed = prepared.torque - 0.01
    computed[where[: len(computed)]] -= 1.0
    return Prediction(prepared, computed)


def test_an_interval_with_a_reversal_is_one_whatever_surrounds_it() -> None:
    phase = phases(building.prepared(building.record(noise=0.001)))[:, 0]
    edges = np.diff((phase == "reversal").astype(int))
    start = int(np.flatnonzero(edges == 1)[4]) + 1
    end = start + int(np.argmax(phase[start:] != "reversal"))
    beside = np.zeros(len(phase), bool)
    beside[start - 3 : start] = beside[end : end + 3] = True
    (worst,) = worst_windows([prediction(beside)], 1)
    assert worst.phase == "reversal"


def test_an_interval_without_one_has_the_phase_of_most_of_its_error() -> None:
    recording = building.prepared(building.record(noise=0.001))
    phase = phases(recording)[:, 0]
    length = round(0.25 * recording.rate)
    clear = [row for row in range(len(phase) - length) if "reversal" not in phase[row - length : row + 2 * length]]
    inside = np.zeros(len(phase), bool)
    inside[clear[len(clear) // 2]] = True
    (worst,) = worst_windows([replace(prediction(inside))], 1)
    assert worst.phase == phase[inside][0]

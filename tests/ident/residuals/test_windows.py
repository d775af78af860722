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


def test_an_interval_has_the_phase_of_most_of_its_error_whatever_else_is_in_it() -> None:
    phase = phases(building.prepared(building.record(noise=0.001)))[:, 0]
    edges = np.diff((phase == "reversal").astype(int))
    start = int(np.flatnonzero(edges == 1)[4]) + 1
    before = np.zeros(len(phase), bool)
    before[start - 5 : start] = True
    (worst,) = worst_windows([prediction(before)], 1)
    assert worst.phase == phase[start - 1] != "reversal"


def test_an_interval_within_one_phase_has_that_phase() -> None:
    recording = building.prepared(building.record(noise=0.001))
    phase = phases(recording)[:, 0]
    length = round(0.25 * recording.rate)
    clear = [row for row in range(len(phase) - length) if "reversal" not in phase[row - length : row + 2 * length]]
    inside = np.zeros(len(phase), bool)
    inside[clear[len(clear) // 2]] = True
    (worst,) = worst_windows([replace(prediction(inside))], 1)
    assert worst.phase == phase[inside][0]

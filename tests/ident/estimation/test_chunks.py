"""A long recording in stretches says the same as all at once."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation import chunks
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Recording


@pytest.mark.parametrize("names", [(), ("rod_inertia", "stribeck", "thermal_drift"), ("presliding_hysteresis",)])
@pytest.mark.parametrize("size", [1234, 3001])
def test_stretches_say_what_the_whole_says(
    names: tuple[str, ...], size: int, make: Callable[..., Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = make(rate=500.0, cycles=3, noise=0.01)
    position = recording.position.copy()
    position[2000:2004, 1] = np.nan
    course = prepare(Recording(**{**vars(recording), "position": position}), "parallel", 30.0)
    composition, known = ModelStructure(course.as_recorded.mechanism, course.as_recorded.rig), library()
    for name in names:
        composition = composition.with_term(Term(name, known[name], (0, 1, 2)))
    x = np.array([1.0 if entry.linear else entry.scale for entry in composition.parameters])
    whole = TorquePredictor(course).linearized(composition, x, nonlinear=False)
    monkeypatch.setattr(chunks, "LONGEST", size)
    assert len(list(chunks.overlapping_chunks(course))) > 2
    torque, derivatives = chunks.linearized(course, composition, x)
    np.testing.assert_allclose(torque, whole[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(derivatives, whole[1][:, :, composition.linear], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(chunks.torque(course, composition, x), torque)

"""A model gives the same torque in chunks as on the whole recording."""

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
@pytest.mark.parametrize(("size", "sign"), [(1234, 1.0), (3001, 1.0), (1234, -1.0)])
def test_chunks_give_the_same_torque_and_derivatives_as_the_whole(
    names: tuple[str, ...], size: int, sign: float, make: Callable[..., Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = make(rate=500.0, cycles=3, noise=0.01)
    position = recording.position.copy()
    position[2000:2004, 1] = np.nan
    prepared = prepare(Recording(**{**vars(recording), "position": position}), "parallel", 30.0)
    structure, effects = ModelStructure(prepared.as_recorded.mechanism, prepared.as_recorded.rig), library()
    for name in names:
        structure = structure.with_term(Term(name, effects[name], (0, 1, 2)))
    # A negative time constant: friction grows until the end of the recording, not of a chunk.
    x = np.array([1.0 if entry.linear else sign * entry.scale for entry in structure.parameters])
    expected = TorquePredictor(prepared).linearized(structure, x, nonlinear=False)
    monkeypatch.setattr(chunks, "CHUNK_LENGTH", size)
    assert len(list(chunks.overlapping_chunks(prepared))) > 2
    torque, derivatives = chunks.linearized(prepared, structure, x)
    np.testing.assert_allclose(torque, expected[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(derivatives, expected[1][:, :, structure.linear], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(chunks.torque(prepared, structure, x), torque)

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.identification.prediction import Prediction
from recordings.recording import Floats, Recording

Planted = Callable[[Floats], Prediction]


@pytest.fixture(scope="session")
def prepared(make: Callable[..., Recording]) -> PreparedRecording:
    """Four cycles of fig5a."""
    recording = make(cycles=4)
    return prepare(recording, "parallel", None)


@pytest.fixture(scope="session")
def planted(prepared: PreparedRecording) -> Planted:
    """Return a function that makes a prediction with a given residual (m, dof)."""
    return lambda residual: Prediction(replace(prepared, torque=prepared.torque + residual), prepared.torque)


@pytest.fixture
def noise(prepared: PreparedRecording) -> Floats:
    """White noise of 0.1 N m."""
    return 0.1 * np.random.default_rng(0).normal(size=prepared.torque.shape)

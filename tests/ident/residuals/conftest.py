from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.data.dataset import Dataset, build
from ident.dynamics import mechanisms
from ident.identification.prediction import Prediction
from recordings.recording import Floats, Recording

Planted = Callable[[Floats], Prediction]


@pytest.fixture(scope="session")
def dataset(make: Callable[..., Recording]) -> Dataset:
    """Four cycles of fig5a."""
    recording = make(cycles=4)
    return build(recording, mechanisms.create(recording.rig), "parallel", None)


@pytest.fixture(scope="session")
def planted(dataset: Dataset) -> Planted:
    """Return a function that makes a prediction with a given residual (m, dof)."""
    return lambda residual: Prediction(replace(dataset, torque=dataset.torque + residual), dataset.torque)


@pytest.fixture
def noise(dataset: Dataset) -> Floats:
    """White noise of 0.1 N m."""
    return 0.1 * np.random.default_rng(0).normal(size=dataset.torque.shape)

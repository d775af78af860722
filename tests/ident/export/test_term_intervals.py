"""Intervals of the RMS of each cause."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.export import paths
from ident.export.term_intervals import relative_half_widths
from ident.identification.model import Model, rig_of
from recordings.recording import Floats, Recording


@pytest.fixture(scope="module")
def model(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Model:
    file = write(make(cycles=2, rate=250.0, noise=0.05, path=tmp_path_factory.mktemp("fit") / "a.mcap"))
    return ident.fit([file], method="ls", without=["rod_inertia"])


def test_half_widths_are_the_spread_under_parameters_drawn_from_their_covariance(model: Model) -> None:
    assessment = model.file.assessment
    chunk = paths.from_trajectory("fig5b", rig_of(model.file), 1, 50.0).excerpt()
    widths = relative_half_widths(model, chunk)
    half = np.array([np.diff(entry.shape_ci95 or (0, 0))[0] / 2 for entry in model.file.parameters])
    covariance = np.array(assessment.correlation, float) * np.outer(half, half)
    dynamics, rng = model.dynamics, np.random.default_rng(0)
    linear = dynamics.structure.linear

    def rms(values: Floats) -> dict[str, Floats]:
        terms = InverseDynamics(dynamics.structure, values).terms(chunk.inputs_of(dynamics))
        whole = {**terms, "torque": np.sum(list(terms.values()), axis=0)}
        return {name: np.sqrt((each**2).mean(axis=0)) for name, each in whole.items()}

    drawn = []
    for error in rng.multivariate_normal(np.zeros(len(half)), covariance, 300):
        values = dynamics.values.copy()
        values[linear] += error
        drawn.append(rms(values))
    for name, of_model in rms(dynamics.values).items():
        spread = np.std([each[name] for each in drawn], axis=0) / of_model
        np.testing.assert_allclose(widths[name], spread, rtol=0.2)


def test_a_model_without_assessment_has_no_intervals(model: Model) -> None:
    bare = Model(model.file.model_copy(update={"assessment": None}), model.library)
    chunk = paths.from_trajectory("fig5b", rig_of(model.file), 1, 50.0).excerpt()
    assert relative_half_widths(bare, chunk) is None

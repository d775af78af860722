"""The model file of a model of the selection."""

import numpy as np
import pytest

from ident.diagnosis.document.result import METHOD, model_file
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import rms
from ident.diagnosis.unknown.unexplained_residual import estimate_unexplained
from ident.dynamics.motion import Motion
from ident.identification.model_file import ModelFile
from recordings.recording import Floats
from tests.ident import building


def stribeck(motion: Motion) -> Floats:
    return np.sign(motion.velocity) * np.exp(-((motion.velocity / 0.3) ** 2))


@pytest.fixture(scope="module")
def model() -> FittedModel:
    """A model with an effect that has a shape, fitted to a recording that has it."""
    recordings = [building.record(noise=0.05, extra=stribeck, shape=shape, seed=shape) for shape in (0, 1)]
    split = building.split(recordings[:1], recordings[1:])
    structure = building.structure(recordings[0], "stribeck")
    return FittedModel(
        split, split.fit(structure, np.array([*building.parameters(), 0.5, 0.5, 1.0])[: len(structure.parameters)])
    )


@pytest.fixture(scope="module")
def file(model: FittedModel) -> ModelFile:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ident.identification.model_file.sha256", lambda path: path.name)
        return model_file(model, estimate_unexplained(model, ()))


def test_all_values_are_those_of_the_model(model: FittedModel, file: ModelFile) -> None:
    values = {entry.name: entry.value for entry in file.all_parameters}
    assert values == dict(
        zip((entry.name for entry in model.solution.structure.parameters), model.solution.x.tolist(), strict=True)
    )
    assert [entry.name for entry in file.searched] == ["stribeck.v_s"]
    assert file.terms[0].shapes["v_s"] == values["stribeck.v_s"]
    assert file.method.name == METHOD


def test_all_parameters_have_intervals_around_the_truth(file: ModelFile) -> None:
    truth = {"stribeck.a1": 1.0, "stribeck.v_s": 0.3, "I_1": building.INERTIA}
    for entry in file.all_parameters:
        assert entry.shape_ci95 is not None
        assert entry.shape_ci95 == pytest.approx(entry.ci95, rel=1e-12), "the torque was measured"
        width = entry.shape_ci95[1] - entry.shape_ci95[0]
        assert abs(entry.value - truth.get(entry.name, entry.value)) < 2 * width


def test_errors_are_those_of_the_scored_rows(model: FittedModel, file: ModelFile) -> None:
    assert file.validate_ is not None
    assert file.train.fitted.rms == pytest.approx(tuple(rms(model.residuals, model.split.train)))
    assert file.validate_.fitted.rms == pytest.approx(tuple(rms(model.residuals, model.split.test)))


def test_the_verdict_goes_into_the_file(model: FittedModel, file: ModelFile) -> None:
    assert file.residual_test is not None
    assert file.residual_test.noise_rms == tuple(model.noise_floor.rms.tolist())
    assert file.residual_test.verdict == "within-noise"

"""The one test of a residual against the noise floor."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.train_test_split import split_recordings
from ident.diagnosis.unknown.residual_test import check_residual, residual_test, score
from ident.diagnosis.unknown.unexplained_residual import estimate_unexplained
from ident.dynamics.structure import ModelStructure
from ident.identification.model_file import ResidualTest
from ident.identification.prediction import Prediction
from recordings.recording import Floats
from tests.ident import building

NOISE = 0.05


@pytest.fixture(autouse=True)
def _files(monkeypatch: pytest.MonkeyPatch) -> None:
    """The recordings are in memory only, so that they have no digest."""
    monkeypatch.setattr("ident.identification.model_file.sha256", lambda path: path.name)


def predicted(extra: building.Torque | None = None, cycles: int = 4) -> tuple[Prediction, ModelStructure, Floats]:
    """A recording with noise and `extra` torque, predicted by the mechanism alone with its true parameters."""
    recording = building.record(noise=NOISE, cycles=cycles, extra=extra)
    prepared = building.prepared(recording)
    structure = building.structure(recording)
    return Prediction(prepared, prepared.regressor @ building.parameters()), structure, building.parameters()


def checked(extra: building.Torque | None = None, cycles: int = 4) -> ResidualTest:
    prediction, structure, x = predicted(extra, cycles)
    test = check_residual([prediction], structure, x)
    assert test is not None
    return test


def test_noise_alone_is_within_the_noise() -> None:
    test = checked()
    assert test.verdict == "within-noise"
    assert test.noise_rms[0] == pytest.approx(np.hypot(test.repetition_rms[0] or 0, test.quantization_rms[0] or 0))
    assert [source.name for source in test.recordings] == ["bench.mcap"]


def test_what_repeats_with_the_motion_is_above_the_noise() -> None:
    test = checked(lambda motion: 0.5 * np.sin(3 * motion.position))
    assert test.verdict == "above-noise"
    assert test.structured_rms[0] == pytest.approx(0.5 / np.sqrt(2), rel=0.3)
    assert test.structured_share > 0.9


@pytest.mark.parametrize("size", [0.0, 1.0])
def test_without_repetition_the_spectrum_tells_the_floor(size: float) -> None:
    test = checked(lambda motion: size * np.cos(5 * motion.position), cycles=1)
    assert test.verdict == ("above-noise" if size else "within-noise")


def test_it_is_that_of_the_diagnosis() -> None:
    """The same rows and parameters give the same floor and verdict as a model of the selection."""
    prediction, structure, x = predicted()
    split = split_recordings([prediction.prepared], [])
    model = FittedModel(split, split.fit(structure, x))
    fitted = residual_test(model, estimate_unexplained(model))
    again = check_residual([model.predictions[0]], structure, model.solution.x)
    assert again is not None
    assert again.verdict == fitted.verdict
    assert again.noise_rms == pytest.approx(fitted.noise_rms, rel=0.2)


def test_rows_at_standstill_are_not_scored() -> None:
    prediction, structure, x = predicted()
    (scored,) = score([prediction], structure, x, None)
    assert scored.scored is not None
    speed = np.abs(prediction.prepared.motion.velocity)
    left_out = prediction.prepared.usable & ~scored.scored
    assert np.nanmax(speed[left_out]) < 0.3 * np.nanmax(speed)
    assert 0.5 < scored.scored.mean() < 1.0
    assert np.isnan(scored.scored_residual).sum() >= (~scored.scored).sum()


def test_a_joint_that_never_moves_has_no_test() -> None:
    prediction, structure, x = predicted()
    still = replace(prediction.prepared, torque=np.full_like(prediction.prepared.torque, np.nan))
    assert check_residual([Prediction(still, prediction.computed)], structure, x) is None

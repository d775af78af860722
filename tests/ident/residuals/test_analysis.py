"""The complete analysis of a residual, and its first sentence."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from ident.identification.model_file import FloorVerdict, ResidualTest
from ident.identification.prediction import Prediction
from ident.residuals.analysis import WINDOWS, ResidualAnalysis, analyse
from recordings.recording import Floats
from tests.ident import building
from tests.ident.residuals.conftest import Planted


@pytest.fixture
def analysed(planted: Planted, noise: Floats) -> ResidualAnalysis:
    """Joint 2 lacks a torque that repeats with the motion."""
    prediction = planted(noise)
    residual = noise.copy()
    residual[:, 1] += np.nan_to_num(np.cos(4 * prediction.prepared.motion.position[:, 1]))
    return analyse(None, [planted(residual)])


def test_noise_and_repeating_part_of_each_joint_add_up(analysed: ResidualAnalysis) -> None:
    assert [joint.summary.number for joint in analysed.joints] == [1, 2, 3]
    for joint, repeats in zip(analysed.joints, (False, True, False), strict=True):
        assert joint.split.noise_rms == pytest.approx(0.1, rel=0.05)
        assert joint.split.total == pytest.approx(joint.summary.rms**2, rel=0.01)
        assert joint.split.above_noise > 0.9 if repeats else joint.split.above_noise < 0.1
    assert analysed.joints[0].summary.rms == pytest.approx(0.1, rel=0.05)


def test_windows_are_sorted_by_their_size_relative_to_the_joint(analysed: ResidualAnalysis) -> None:
    assert len(analysed.windows) == WINDOWS
    sizes = [window.times_overall for window in analysed.windows]
    assert sizes == sorted(sizes, reverse=True)
    for window in analysed.windows:
        overall = analysed.joints[window.joint - 1].summary.rms
        assert window.times_overall == pytest.approx(window.rms / overall)


def test_curve_over_the_true_quantity_explains_the_residual(analysed: ResidualAnalysis) -> None:
    explained = {curve.axis: curve.explained for curve in analysed.joints[1].curves}
    assert explained["position"] > 0.9
    assert max(curve.explained for curve in analysed.joints[0].curves) < 0.2


def test_two_recordings_are_analysed_together(planted: Planted, noise: Floats) -> None:
    quiet, loud = planted(noise), planted(3 * noise)
    both = analyse(None, [quiet, loud])
    assert both.joints[0].summary.rms == pytest.approx(0.1 * np.sqrt((1 + 9) / 2), rel=0.05)
    assert both.predictions == (quiet, loud)


def _stribeck(motion: Motion) -> Floats:
    return np.exp(-((motion.velocity[:, 0] / 0.3) ** 2)) * motion.direction[:, 0]


def _load_friction(motion: Motion) -> Floats:
    return np.abs(building.INERTIA * motion.acceleration[:, 0]) * motion.direction[:, 0]


@pytest.mark.parametrize(
    ("expected", "torque", "size", "shape"),
    [
        ("wave over its position", lambda motion: np.sin(14 * motion.position[:, 0]), 0.5, 1),
        ("over its position", lambda motion: motion.position[:, 0], 1.0, 3),
        ("over its velocity", _stribeck, 0.4, 6),
        ("computed load, reversed with", _load_friction, 1.0, 8),
        ("over joint 2's acceleration", lambda motion: motion.acceleration[:, 1], 0.4, 13),
    ],
)
def test_the_first_sentence_names_the_variable(
    expected: str, torque: Callable[[Motion], Floats], size: float, shape: int
) -> None:
    planted = np.zeros((len(building.motion_of(2).position), 2))
    planted[:, 0] = torque(building.motion_of(2, shape=shape))
    planted *= size / np.sqrt(np.mean(planted[:, 0] ** 2))
    recording = building.record(2, noise=0.05, seed=shape, shape=shape, extra=lambda motion: planted)
    model = building.fitted(building.split([recording]))
    prediction = Prediction(building.prepared(recording), model.computed[0], model.split.scored[0])
    sentence, *_ = analyse(None, [prediction]).sentences
    assert expected in sentence
    assert "wave" not in expected or sentence.endswith(": 14.0 periods per turn.")


def test_no_quantity_explains_noise_or_a_residual_of_zero(planted: Planted, noise: Floats) -> None:
    first, *_ = analyse(None, [planted(noise)]).sentences
    assert first == "No quantity explains 20 % of the squared residual of any joint."
    assert all(influence.explained == 0 for influence in analyse(None, [planted(np.zeros_like(noise))]).influences)


@pytest.mark.parametrize("verdict", ["within-noise", "above-noise", "unknown"])
def test_only_a_residual_above_the_noise_is_explained(planted: Planted, noise: Floats, verdict: FloorVerdict) -> None:
    wave = np.nan_to_num(np.cos(4 * planted(noise).prepared.motion.position)) * [0, 1, 0]
    known = (0.1, 0.1, 0.1)
    test = ResidualTest(
        verdict=verdict,
        bandwidth_hz=30.0,
        noise_rms=known,
        repetition_rms=known,
        quantization_rms=known,
        structured_rms=known,
        structured_share=0.5,
        recordings=(),
    )
    sentences = analyse(None, [planted(noise + wave)], test).sentences
    assert test.sentence in sentences
    assert sentences[0].startswith("Joint 2:") == (verdict != "within-noise")

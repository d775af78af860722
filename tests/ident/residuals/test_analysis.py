"""The complete analysis of a residual: its parts belong to the right joints."""

import numpy as np
import pytest

from ident.residuals.analysis import WINDOWS, ResidualAnalysis, analyse
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted


@pytest.fixture
def analysed(planted: Planted, noise: Floats) -> ResidualAnalysis:
    """Joint 2 lacks a torque that repeats with the motion."""
    prediction = planted(noise)
    residual = noise.copy()
    residual[:, 1] += np.nan_to_num(np.cos(4 * prediction.prepared.motion.position[:, 1]))
    return analyse(None, [planted(residual)])


def test_planted_residual_is_in_its_joint(analysed: ResidualAnalysis) -> None:
    summaries = [joint.summary for joint in analysed.joints]
    assert [summary.number for summary in summaries] == [1, 2, 3]
    assert summaries[1].rms > 4 * summaries[0].rms
    assert summaries[0].rms == pytest.approx(0.1, rel=0.05)


def test_noise_and_repeating_part_add_up(analysed: ResidualAnalysis) -> None:
    for joint in analysed.joints:
        assert joint.split is not None
        assert joint.split.noise_rms == pytest.approx(0.1, rel=0.05)
        assert joint.split.total == pytest.approx(joint.summary.rms**2, rel=0.01)
    above = [joint.split.above_noise for joint in analysed.joints if joint.split]
    assert above[1] > 0.9
    assert max(above[0], above[2]) < 0.1


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


def test_scaling_of_the_torque_scales_the_residual(planted: Planted, noise: Floats) -> None:
    once, twice = analyse(None, [planted(noise)]), analyse(None, [planted(2 * noise)])
    for first, second in zip(once.joints, twice.joints, strict=True):
        assert second.summary.rms == pytest.approx(2 * first.summary.rms)
        assert first.split is not None
        assert second.split is not None
        assert second.split.noise_rms == pytest.approx(2 * first.split.noise_rms)

"""The residual above the noise floor."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.ripple.lines import Vibration
from ident.diagnosis.unknown.unexplained_residual import UnexplainedResidual, estimate_unexplained, with_vibrations
from recordings.recording import Recording
from tests.ident import building

BAND = np.sqrt(2 * building.CUTOFF / building.RATE)


def unexplained(recording: Recording, **options: object) -> UnexplainedResidual:
    data = building.split([recording])
    model = building.fitted(data)
    return estimate_unexplained(model, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(5))
def test_correct_model_leaves_only_noise(seed: int) -> None:
    result = unexplained(building.record(2, 5, noise=0.1, seed=seed))
    assert not result.significant
    assert result.sentence == "only noise and encoder quantization."
    assert result.variables == ()
    assert result.share < 0.2


def test_structured_part_has_the_planted_size() -> None:
    """A torque that no parameter of the mechanism reproduces, apart from a small part of it."""

    def ripple(motion: building.Motion) -> np.ndarray:
        return 0.3 * np.cos(5 * motion.position)

    result = unexplained(building.record(cycles=6, noise=0.1, extra=ripple))
    assert result.significant
    structured, noise = 0.3 / np.sqrt(2), 0.1 * BAND
    assert result.rms[0] == pytest.approx(structured, rel=0.2)
    assert result.share == pytest.approx(structured**2 / (structured**2 + noise**2), abs=0.05)
    assert "position" in result.variables


def test_vibration_depends_on_frequency() -> None:
    recording = building.record(cycles=10, noise=0.02)
    assert recording.effort is not None
    recording.effort[:] += 0.3 * np.sin(2 * np.pi * 7.37 * recording.time)[:, None]
    result = unexplained(recording)
    assert result.significant
    assert "frequency" in result.variables
    assert "a vibration of 7.37 Hz" in result.sentence


@pytest.mark.parametrize(("share", "relevant"), [(0.02, True), (0.002, False)])
def test_vibration_above_the_low_pass_is_structure_if_it_is_relevant(share: float, relevant: bool) -> None:
    """Below it, nothing is left."""
    before = unexplained(building.record(2, 5, noise=0.1))
    line = Vibration(1, 43.21, share * np.sqrt(2) * 7.0)
    result = with_vibrations(before, [line], np.array([100.0, 7.0]))
    assert result.significant is relevant
    assert result.variables == (("frequency",) if relevant else ())
    assert result.sentence == ("joint 2: a vibration of 43.21 Hz." if relevant else before.sentence)
    assert (result.rms == before.rms).all()


def test_steady_change_depends_on_time() -> None:
    recording = building.record(cycles=8, noise=0.05)
    assert recording.effort is not None
    direction = np.sign(building.motion_of(cycles=8).velocity)
    recording.effort[:] += 0.5 * direction * (recording.time / recording.time[-1])[:, None]
    result = unexplained(recording)
    assert result.significant
    assert "time" in result.variables
    assert "it changes from cycle to cycle" in result.sentence


def test_change_at_an_instant_is_named_so() -> None:
    recording = building.record(cycles=5, noise=0.02)
    assert recording.effort is not None
    shape = np.sin(3 * building.motion_of(cycles=5).position[:, 0])
    recording.effort[:] += np.where(recording.time >= 0.5 * recording.time[-1], shape, 0.0)[:, None]
    result = unexplained(recording)
    assert result.significant
    assert "time" in result.variables
    assert "frequency" not in result.variables
    assert "it changes at one instant (step in cycle 3)" in result.sentence


def test_without_repetition_noise_is_no_structure() -> None:
    result = unexplained(building.record(cycles=1, noise=0.1))
    assert not result.significant
    assert result.sentence == "only noise and encoder quantization."


def test_without_repetition_a_curve_on_test_rows_is_structure() -> None:
    def ripple(motion: building.Motion) -> np.ndarray:
        return 0.3 * np.cos(5 * motion.position)

    result = unexplained(building.record(cycles=1, noise=0.05, extra=ripple))
    assert result.significant
    assert "position" in result.variables
    assert 0.1 < result.rms[0] < 0.35 / np.sqrt(2)


@pytest.mark.parametrize(("hertz", "vibrates"), [(11.3, True), (3 / building.PERIOD, False)])
def test_without_repetition_a_vibration_has_no_frequency_of_the_motion(hertz: float, vibrates: bool) -> None:
    recording = building.record(cycles=6, noise=0.02)
    assert recording.effort is not None
    recording.effort[:] += 0.05 * np.sin(2 * np.pi * hertz * recording.time)[:, None]
    result = unexplained(replace(recording, repeat=np.zeros_like(recording.repeat)))
    assert ("frequency" in result.variables) is vibrates
    assert ("a vibration of 11.30 Hz" in result.sentence) is vibrates


def test_known_dependences_are_not_searched_again() -> None:
    recording = building.record(cycles=6, noise=0.02, extra=lambda motion: 0.3 * np.cos(5 * motion.position))
    result = unexplained(recording, known=())
    assert result.significant
    assert result.dependences == ()
    assert result.sentence == "it repeats with the motion, but depends on no single variable."

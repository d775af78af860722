"""The residual against the noise floor, and what is left of it above."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.ripple.waves import Vibration
from ident.diagnosis.split.train_test_split import split_recordings
from ident.diagnosis.unknown.residual_test import (
    UnexplainedResidual,
    check_residual,
    estimate_unexplained,
    residual_test,
    score,
    with_vibrations,
)
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure
from ident.identification.prediction import Prediction
from recordings.recording import Floats, Recording
from tests.ident import building


def predicted(extra: building.Torque | None = None, cycles: int = 4) -> tuple[Prediction, ModelStructure, Floats]:
    """A recording with noise and `extra` torque, predicted by the mechanism alone with its true parameters."""
    recording = building.record(noise=0.05, cycles=cycles, extra=extra)
    prepared = building.prepared(recording)
    structure = building.structure(recording)
    return Prediction(prepared, prepared.regressor @ building.parameters()), structure, building.parameters()


@pytest.mark.parametrize(("size", "verdict"), [(0.0, "within-noise"), (0.5, "above-noise")])
@pytest.mark.parametrize("cycles", [1, 4])
def test_only_what_repeats_with_the_motion_is_above_the_noise(size: float, verdict: str, cycles: int) -> None:
    """Without repetition, the spectrum tells the floor."""
    prediction, structure, x = predicted(lambda motion: size * np.cos(5 * motion.position), cycles)
    test = check_residual([prediction], structure, x)
    assert test is not None
    assert test.verdict == verdict
    assert test.noise_rms[0] == pytest.approx(np.hypot(test.repetition_rms[0] or 0, test.quantization_rms[0] or 0))
    assert [source.name for source in test.recordings] == ["bench.mcap"]
    if size and cycles > 1:
        assert test.structured_rms[0] == pytest.approx(size / np.sqrt(2), rel=0.3)
        assert test.structured_share > 0.9


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


def test_rows_beyond_the_travel_of_a_curve_are_not_scored() -> None:
    prediction, _, _ = predicted()
    position = prediction.prepared.motion.position[:, 0]
    structure = building.structure(prediction.prepared.recording, "position_torque")
    for low, share in ((np.nanmin(position), 1.0), (np.nanmedian(position), 0.5), (np.nanmax(position), 1.0)):
        x = np.concatenate([building.parameters(), np.zeros(9), [low, np.nanmax(position) + 1]])
        (scored,) = score([prediction], structure, x, None)
        (whole,) = score([prediction], building.structure(prediction.prepared.recording), building.parameters(), None)
        assert scored.scored is not None
        assert whole.scored is not None
        assert scored.scored.sum() == pytest.approx(share * whole.scored.sum(), rel=0.1)


def test_a_joint_that_never_moves_has_no_test() -> None:
    prediction, structure, x = predicted()
    still = replace(prediction.prepared, torque=np.full_like(prediction.prepared.torque, np.nan))
    assert check_residual([Prediction(still, prediction.computed)], structure, x) is None


IN_BAND = np.sqrt(2 * building.CUTOFF / building.RATE)
"""Amplitude ratio of white noise that the low-pass leaves."""


def unexplained(recording: Recording, **options: object) -> UnexplainedResidual:
    model = building.fitted(building.split([recording]))
    return estimate_unexplained(model, **options)  # type: ignore[arg-type]


def ripple(motion: Motion) -> Floats:
    """A torque that hardly any parameter of the mechanism reproduces."""
    return 0.3 * np.cos(5 * motion.position)


def share_of_recording(motion: Motion) -> Floats:
    """(n, 1) from 0 to 1."""
    return np.linspace(0, 1, len(motion.position))[:, None]


def vibration(motion: Motion) -> Floats:
    return 0.3 * np.sin(2 * np.pi * 7.37 * np.arange(len(motion.position)) / building.RATE)[:, None]


def growing(motion: Motion) -> Floats:
    return 0.5 * np.sign(motion.velocity) * share_of_recording(motion)


def sudden(motion: Motion) -> Floats:
    return np.where(share_of_recording(motion) >= 0.5, np.sin(3 * motion.position), 0.0)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("cycles", [1, 5])
def test_correct_model_leaves_only_noise(seed: int, cycles: int) -> None:
    result = unexplained(building.record(2, cycles, noise=0.1, seed=seed))
    assert not result.significant
    assert result.sentence == "only noise and encoder quantization."
    assert result.variables == ()


@pytest.mark.parametrize(
    ("torque", "cycles", "variable", "sentence"),
    [
        (ripple, 6, "position", ""),
        (ripple, 1, "position", ""),
        (vibration, 10, "frequency", "a vibration of 7.37 Hz"),
        (growing, 8, "time", "it changes from cycle to cycle"),
        (sudden, 5, "time", "it changes at one instant (step in cycle 3)"),
    ],
)
def test_structure_is_named_with_what_it_depends_on(
    torque: building.Torque, cycles: int, variable: str, sentence: str
) -> None:
    result = unexplained(building.record(cycles=cycles, noise=0.02, extra=torque))
    assert result.significant
    assert variable in result.variables
    assert sentence in result.sentence
    assert torque is not sudden or "frequency" not in result.variables


def test_structured_part_has_the_planted_size() -> None:
    result = unexplained(building.record(cycles=6, noise=0.1, extra=ripple))
    structured, noise = 0.3 / np.sqrt(2), 0.1 * IN_BAND
    assert result.rms[0] == pytest.approx(structured, rel=0.2)
    assert result.share == pytest.approx(structured**2 / (structured**2 + noise**2), abs=0.05)
    single = unexplained(building.record(cycles=1, noise=0.05, extra=ripple))
    assert 0.1 < single.rms[0] < 0.35 / np.sqrt(2)


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


@pytest.mark.parametrize(("hertz", "vibrates"), [(11.3, True), (3 / building.PERIOD, False)])
def test_without_repetition_a_vibration_has_no_frequency_of_the_motion(hertz: float, vibrates: bool) -> None:
    recording = building.record(cycles=6, noise=0.02)
    assert recording.effort is not None
    recording.effort[:] += 0.05 * np.sin(2 * np.pi * hertz * recording.time)[:, None]
    result = unexplained(replace(recording, repeat=np.zeros_like(recording.repeat)))
    assert ("frequency" in result.variables) is vibrates
    assert ("a vibration of 11.30 Hz" in result.sentence) is vibrates


def test_known_dependences_are_not_searched_again() -> None:
    recording = building.record(cycles=6, noise=0.02, extra=ripple)
    result = unexplained(recording, known=())
    assert result.significant
    assert result.dependences == ()
    assert result.sentence == "it repeats with the motion, but depends on no single variable."

from collections.abc import Callable

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.identification.model_file import FloorVerdict, ResidualTest
from ident.identification.prediction import Prediction
from ident.residuals.phases import joint_residuals, phases, sentences
from recordings.recording import Floats, Recording


@pytest.fixture(scope="module")
def prepared(recording: Recording) -> PreparedRecording:
    return prepare(recording, "parallel", None)


def noise(prepared: PreparedRecording, size: float = 0.1) -> Floats:
    return size * np.random.default_rng(0).normal(size=prepared.torque.shape)


def description(prepared: PreparedRecording, error: Floats) -> str:
    return " ".join(sentences(joint_residuals([Prediction(prepared, prepared.torque - error)])))


def test_uniform_noise_is_not_notable(prepared: PreparedRecording) -> None:
    assert "No joint and no phase of the motion stands out." in description(prepared, noise(prepared))


def test_a_zero_residual_is_not_notable(prepared: PreparedRecording) -> None:
    assert "stands out" in description(prepared, np.zeros_like(prepared.torque))


def test_the_worst_joint_is_named(prepared: PreparedRecording) -> None:
    text = description(prepared, noise(prepared) * [1, 3, 1])
    assert "Joint 2 has the largest residual" in text
    assert "phase" not in text


@pytest.mark.parametrize("phase", ["reversal", "acceleration", "cruise"])
def test_the_worst_phase_is_named(prepared: PreparedRecording, phase: str) -> None:
    inside = (phases(prepared) == phase) * [0, 0, 1]
    text = description(prepared, noise(prepared) * (1 + 4 * inside))
    assert f"Joint 3: {5.0:.0f}" in text or "Joint 3: 4." in text
    assert f"in phase '{phase}'" in text
    assert "Joint 1:" not in text


@pytest.mark.parametrize("verdict", ["within-noise", "above-noise", "unknown"])
def test_only_a_residual_above_the_noise_gets_hints(prepared: PreparedRecording, verdict: FloorVerdict) -> None:
    inside = (phases(prepared) == "reversal") * [0, 0, 1]
    prediction = Prediction(prepared, prepared.torque - noise(prepared) * (1 + 4 * inside))
    text = " ".join(sentences(joint_residuals([prediction]), verdict_of(verdict)))
    assert ("look at friction" in text) == (verdict != "within-noise")
    assert verdict_of(verdict).sentence in text


def verdict_of(verdict: FloorVerdict) -> ResidualTest:
    known = (0.1, 0.1, 0.1)
    return ResidualTest(
        verdict=verdict,
        bandwidth_hz=30.0,
        noise_rms=known,
        repetition_rms=known,
        quantization_rms=known,
        structured_rms=known,
        structured_share=0.5,
        recordings=(),
    )


def test_rows_that_are_not_scored_count_in_all_rows_only(prepared: PreparedRecording) -> None:
    error = np.zeros_like(prepared.torque)
    error[: len(error) // 2] = 1.0
    prediction = Prediction(prepared, prepared.torque - error, scored=prepared.usable & (error == 0))
    for joint in joint_residuals([prediction]):
        assert joint.rms == pytest.approx(0.0, abs=1e-12)
        assert joint.rms_all > 0.5


def test_phases_follow_the_motion(make: Callable[..., Recording]) -> None:
    recording = make(cycles=1)
    # Two seconds at rest before the approach.
    still = 1000
    signals = {
        name: np.concatenate([np.repeat(getattr(recording, name)[:1], still, axis=0), getattr(recording, name)])
        for name in ("position", "voltage", "repeat")
    }
    signals["voltage"][:still] = 0.1
    longer = Recording(**{**vars(recording), **signals, "time": np.arange(still + len(recording.time)) / 500})
    prepared = prepare(longer, "parallel", None)
    names = phases(prepared)
    at_rest = (prepared.time > 0.2) & (prepared.time < 1.8)
    assert (names[at_rest] == "standstill").all()
    velocity = prepared.motion.velocity
    reversing = np.nonzero((velocity[:-1] * velocity[1:] < 0) & (abs(velocity[:-1]) > 0.01))
    assert (names[reversing] == "reversal").mean() > 0.9
    fast = abs(velocity) > 1.5
    assert not np.isin(names[fast], ["standstill", "reversal"]).any()


def test_shares_of_all_phases_sum_to_one(prepared: PreparedRecording) -> None:
    for joint in joint_residuals([Prediction(prepared, prepared.torque - noise(prepared))]):
        assert sum(phase.time_share for phase in joint.phases.values()) == pytest.approx(1)
        assert sum(phase.error_share for phase in joint.phases.values()) == pytest.approx(1)
        assert joint.rms == pytest.approx(0.1, rel=0.1)

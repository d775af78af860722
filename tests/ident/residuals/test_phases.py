"""Errors by the phase of the motion, and the worst intervals."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.identification.prediction import Prediction
from ident.residuals.phases import joint_residuals, phases, worst_windows
from recordings.recording import Floats, Ints, Recording
from tests.ident import building


@pytest.fixture(scope="module")
def prepared(recording: Recording) -> PreparedRecording:
    return prepare(recording, "parallel", None)


def noise(prepared: PreparedRecording, size: float = 0.1) -> Floats:
    return size * np.random.default_rng(0).normal(size=prepared.torque.shape)


def description(prepared: PreparedRecording, error: Floats) -> str:
    joints = joint_residuals([Prediction(prepared, prepared.torque - error)])
    return " ".join(line for joint in joints for line in joint.sentences)


@pytest.mark.parametrize("size", [0.0, 0.1])
def test_uniform_noise_is_not_notable(prepared: PreparedRecording, size: float) -> None:
    assert not description(prepared, noise(prepared, size))


@pytest.mark.parametrize("phase", ["reversal", "acceleration", "cruise"])
def test_the_phase_with_most_of_the_error_is_named(prepared: PreparedRecording, phase: str) -> None:
    inside = (phases(prepared) == phase) * [0, 0, 1]
    text = description(prepared, noise(prepared) * (1 + 9 * inside))
    assert text.startswith(f"Joint 3: phase '{phase}' has 9")
    assert "of the squared residual, in" in text
    assert "Joint 1:" not in text


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


def worst_phase(wrong: Ints) -> str:
    """Phase of the interval with the largest error of a model that is wrong in the rows `wrong`."""
    prepared = building.prepared(building.record(noise=0.001))
    computed = prepared.torque - 0.01
    computed[wrong] -= 1.0
    (worst,) = worst_windows([Prediction(prepared, computed)], 1)
    return worst.phase


def test_an_interval_has_the_phase_of_most_of_its_error_whatever_else_is_in_it() -> None:
    recording = building.prepared(building.record(noise=0.001))
    phase, length = phases(recording)[:, 0], round(0.25 * recording.rate)
    start = int(np.flatnonzero(np.diff((phase == "reversal").astype(int)) == 1)[4]) + 1
    assert worst_phase(np.arange(start - 5, start)) == phase[start - 1] != "reversal"
    clear = [row for row in range(len(phase) - length) if "reversal" not in phase[row - length : row + 2 * length]]
    inside = clear[len(clear) // 2]
    assert worst_phase(np.array([inside])) == phase[inside]

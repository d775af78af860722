from collections.abc import Callable

import numpy as np
import pytest

from ident.data.dataset import Dataset, build
from ident.dynamics import mechanisms
from ident.residuals.phases import joint_residuals, phases, sentences
from recordings.recording import Floats, Recording


@pytest.fixture(scope="module")
def dataset(recording: Recording) -> Dataset:
    return build(recording, mechanisms.create(recording.rig), "parallel", None)


def noise(dataset: Dataset, size: float = 0.1) -> Floats:
    return size * np.random.default_rng(0).normal(size=dataset.torque.shape)


def description(dataset: Dataset, error: Floats) -> str:
    return " ".join(sentences(joint_residuals([dataset], [dataset.torque - error])))


def test_uniform_noise_is_not_notable(dataset: Dataset) -> None:
    assert "No joint and no phase of the motion stands out." in description(dataset, noise(dataset))


def test_a_zero_residual_is_not_notable(dataset: Dataset) -> None:
    assert "stands out" in description(dataset, np.zeros_like(dataset.torque))


def test_the_worst_joint_is_named(dataset: Dataset) -> None:
    text = description(dataset, noise(dataset) * [1, 3, 1])
    assert "Joint 2 has the largest residual" in text
    assert "phase" not in text


@pytest.mark.parametrize("phase", ["reversal", "acceleration", "cruise"])
def test_the_worst_phase_is_named(dataset: Dataset, phase: str) -> None:
    inside = (phases(dataset) == phase) * [0, 0, 1]
    text = description(dataset, noise(dataset) * (1 + 4 * inside))
    assert f"Joint 3: {5.0:.0f}" in text or "Joint 3: 4." in text
    assert f"in phase '{phase}'" in text
    assert "Joint 1:" not in text


def test_a_residual_larger_than_on_the_training_data_is_reported(dataset: Dataset) -> None:
    training, evaluated = (joint_residuals([dataset], [dataset.torque - noise(dataset, size)]) for size in (0.1, 0.3))
    assert any("residual is 3.0 times" in line for line in sentences(evaluated, training))
    assert not any("that of the training data" in line for line in sentences(training, evaluated))


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
    dataset = build(longer, mechanisms.create(recording.rig), "parallel", None)
    names = phases(dataset)
    at_rest = (dataset.time > 0.2) & (dataset.time < 1.8)
    assert (names[at_rest] == "standstill").all()
    velocity = dataset.motion.velocity
    reversing = np.nonzero((velocity[:-1] * velocity[1:] < 0) & (abs(velocity[:-1]) > 0.01))
    assert (names[reversing] == "reversal").mean() > 0.9
    fast = abs(velocity) > 1.5
    assert not np.isin(names[fast], ["standstill", "reversal"]).any()


def test_shares_of_all_phases_sum_to_one(dataset: Dataset) -> None:
    for joint in joint_residuals([dataset], [dataset.torque - noise(dataset)]):
        assert sum(phase.time_share for phase in joint.phases.values()) == pytest.approx(1)
        assert sum(phase.error_share for phase in joint.phases.values()) == pytest.approx(1)
        assert joint.rms == pytest.approx(0.1, rel=0.1)

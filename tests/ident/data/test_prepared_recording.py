from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ident.data import prepared_recording
from ident.data.prepared_recording import PreparedRecording, prepare
from recordings.errors import BadInput
from recordings.recording import Recording
from tests.ident import building

SIGNALS = ("time", "position", "voltage", "repeat")


def prepare_parallel(recording: Recording) -> PreparedRecording:
    return prepare(recording, "parallel", None)


def selected(recording: Recording, rows: Any) -> Recording:
    return replace(recording, **{name: getattr(recording, name)[rows] for name in SIGNALS})


def with_column(recording: Recording, signal: str, joint: int, value: float) -> Recording:
    values = getattr(recording, signal).copy()
    values[:, joint] = value
    return replace(recording, **{signal: values})


@pytest.fixture(scope="module")
def bench() -> PreparedRecording:
    return building.prepared(building.record(2))


def test_rows_are_the_repeated_motion_only(recording: Recording) -> None:
    prepared = prepare_parallel(recording)
    usable = np.isfinite(prepared.torque).all(axis=1)
    repeated, rows = recording.time[recording.repeat >= 0], prepared.time[usable]
    assert rows[[0, -1]] == pytest.approx(repeated[[0, -1]], abs=1 / prepared.rate)
    assert prepared.regressor[usable].shape == (usable.sum(), 3, 11)
    assert np.isfinite(prepared.regressor[usable]).all()
    everything = replace(recording, repeat=np.full_like(recording.repeat, -1))  # without cycles, all samples are used
    assert prepare_parallel(everything).usable.sum() > prepared.usable.sum()


def test_an_unanswered_sync_is_a_gap(recording: Recording) -> None:
    shorter = selected(recording, np.delete(np.arange(len(recording.time)), [900, 901]))
    prepared, expected = prepare_parallel(shorter), prepare_parallel(recording)
    assert prepared.time[-1] == expected.time[-1]
    lost = np.isnan(prepared.torque) & np.isfinite(expected.torque)
    assert lost.any()
    np.testing.assert_array_equal(prepared.torque[~lost], expected.torque[~lost])


def interrupted_before_motion(recording: Recording) -> Recording:
    run = recording.run.model_copy(update={"exit_status": None})
    return replace(recording, run=run, repeat=np.full_like(recording.repeat, -1))


@pytest.mark.parametrize("n", [1, 2, 7, 30])
@pytest.mark.parametrize("method", ["central", "parallel"])
def test_too_few_samples_are_refused(recording: Recording, n: int, method: str) -> None:
    few = selected(recording, slice(1000, 1000 + n))
    few = replace(few, time=few.time - few.time[0])
    with pytest.raises(BadInput, match=r"expected|constant"):
        prepare(few, method, None)


UNUSABLE: list[tuple[str, Callable[[Recording], Recording]]] = [
    (
        "joint 2 should move, but its position is constant",
        lambda recording: with_column(recording, "position", 1, 0.3),
    ),
    ("joint 3 should move", lambda recording: with_column(recording, "position", 2, np.nan)),
    ("joint 1 is 0 V throughout", lambda recording: with_column(recording, "voltage", 0, 0.0)),
    ("joint 1 is never received", lambda recording: with_column(recording, "voltage", 0, np.nan)),
    ("interrupted before", interrupted_before_motion),
    (
        r"made\.mcap: .*check the angles, their zero offsets and the geometry",
        lambda recording: replace(recording, position=recording.position * [6, 6, -6]),
    ),
    (
        "time that increases from sample to sample expected, 10 s is followed by 9.998 s",
        lambda recording: replace(recording, time=recording.time[::-1]),
    ),
    (
        "at least 37 usable samples per joint expected after preprocessing, 16 of 600",
        lambda recording: selected(recording, slice(600)),
    ),
]


@pytest.mark.parametrize(("message", "corrupt"), UNUSABLE, ids=[message for message, _ in UNUSABLE])
def test_an_unusable_recording_is_refused(recording: Recording, message: str, corrupt: Any) -> None:
    with pytest.raises(BadInput, match=message):
        prepare_parallel(corrupt(recording))


@pytest.mark.parametrize("method", ["parallel", "central", "savgol"])
def test_blocks_give_the_same_regressor_as_the_whole(
    recording: Recording, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    gapped_position = recording.position.copy()
    gapped_position[1000:1003] = np.nan
    gapped = replace(recording, position=gapped_position)
    expected = prepare(gapped, method, None)
    monkeypatch.setattr(prepared_recording, "BLOCK", 97)
    blocks = prepare(gapped, method, None)
    np.testing.assert_array_equal(blocks.regressor, expected.regressor)
    np.testing.assert_array_equal(blocks.nominal, expected.nominal)


def test_true_motion_and_torque_satisfy_the_model(bench: PreparedRecording) -> None:
    motion, expected = bench.as_recorded.motion, building.motion_of(2)
    known = np.isfinite(motion.acceleration)
    for name in ("position", "velocity", "acceleration"):
        error = (getattr(motion, name) - getattr(expected, name))[known]
        assert np.abs(error).max() < 0.02 * np.abs(getattr(expected, name)).max()
    residual = bench.torque - bench.condition(bench.as_recorded.regressor) @ building.parameters(2)
    assert np.nanstd(residual) < 0.01


def test_rows_are_every_so_many_instants_from_the_start_on(bench: PreparedRecording) -> None:
    assert len(bench.instant_time) == len(bench.recording.time)
    np.testing.assert_allclose(bench.instant_time[:: bench.preprocessed.decimation], bench.time)
    late = prepare(bench.recording, "parallel", building.CUTOFF, 100.0)
    np.testing.assert_allclose(late.time, bench.time + 100)
    np.testing.assert_array_equal(late.torque, bench.torque)


def test_conditioning_is_linear_and_keeps_constants(bench: PreparedRecording) -> None:
    x, y = np.random.default_rng(0).normal(size=(2, len(bench.instant_time), 2))
    combined = bench.condition(3 * x - y)
    assert combined.shape == (len(bench.time), 2)
    known = np.isfinite(combined)
    np.testing.assert_allclose(combined[known], (3 * bench.condition(x) - bench.condition(y))[known], atol=1e-9)
    constant = bench.condition(np.full_like(x, 2.5))
    np.testing.assert_allclose(constant[np.isfinite(constant)], 2.5)


def test_correction_of_positions_is_that_of_the_recording(bench: PreparedRecording) -> None:
    """A correction by an offset shifts the motion; one by a factor scales it."""
    rig, motion = bench.as_recorded.rig, bench.as_recorded.motion
    shifted, doubled = (bench.corrected_motion(rig, change).motion for change in (lambda q: q + 0.1, lambda q: 2 * q))
    np.testing.assert_allclose(shifted.position, motion.position + 0.1)
    np.testing.assert_allclose(shifted.velocity, motion.velocity, atol=1e-9)
    np.testing.assert_allclose(shifted.acceleration, motion.acceleration, atol=1e-6)
    np.testing.assert_allclose(doubled.acceleration, 2 * motion.acceleration, atol=1e-6)
    without_cutoff = prepare(bench.recording, "central", None)
    replaced = without_cutoff.with_positions(lambda position: position + 0.1).as_recorded.motion.position
    np.testing.assert_allclose(replaced, without_cutoff.as_recorded.motion.position + 0.1, atol=1e-12)


def test_load_of_effects_is_the_torque_without_friction(bench: PreparedRecording) -> None:
    corrected = bench.as_recorded
    inputs = corrected.effect_inputs(building.RATE, bench.instant_time, building.CUTOFF, building.parameters(2))
    load, acceleration = inputs.rigid_at(corrected.motion), corrected.motion.acceleration
    known = np.isfinite(load)
    assert known.mean() > 0.9
    np.testing.assert_allclose(load[known], building.INERTIA * acceleration[known])

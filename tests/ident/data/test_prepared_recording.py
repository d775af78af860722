from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ident.data import prepared_recording
from ident.data.prepared_recording import PreparedRecording, prepare, prepare_all
from ident.dynamics import mechanisms
from recordings.errors import BadInput
from recordings.recording import Recording
from tests.ident import building


def prepare_parallel(recording: Recording) -> PreparedRecording:
    return prepare(recording, "parallel", None)


def with_column(recording: Recording, signal: str, joint: int, value: float) -> Recording:
    values = getattr(recording, signal).copy()
    values[:, joint] = value
    return replace(recording, **{signal: values})


def test_rows_are_the_repeated_motion_only(recording: Recording) -> None:
    prepared = prepare_parallel(recording)
    usable = np.isfinite(prepared.torque).all(axis=1)
    repeated = recording.time[recording.repeat >= 0]
    assert prepared.time[usable][0] == pytest.approx(repeated[0], abs=1 / prepared.rate)
    assert prepared.time[usable][-1] == pytest.approx(repeated[-1], abs=1 / prepared.rate)
    assert prepared.regressor[usable].shape == (usable.sum(), 3, 11)
    assert np.isfinite(prepared.regressor[usable]).all()


def test_without_cycles_all_samples_are_used(recording: Recording) -> None:
    everything = replace(recording, repeat=np.full_like(recording.repeat, -1))
    assert prepare_parallel(everything).usable.sum() > prepare_parallel(recording).usable.sum()


def test_an_unanswered_sync_is_a_gap(recording: Recording) -> None:
    answered = np.delete(np.arange(len(recording.time)), [900, 901])
    signals = ("time", "position", "voltage", "repeat")
    shorter = replace(recording, **{name: getattr(recording, name)[answered] for name in signals})
    prepared, expected = prepare_parallel(shorter), prepare_parallel(recording)
    assert prepared.time[-1] == expected.time[-1]
    lost = np.isnan(prepared.torque) & np.isfinite(expected.torque)
    assert lost.any()
    np.testing.assert_array_equal(prepared.torque[~lost], expected.torque[~lost])


def interrupted_before_motion(recording: Recording) -> Recording:
    run = recording.run.model_copy(update={"exit_status": None})
    return replace(recording, run=run, repeat=np.full_like(recording.repeat, -1))


def with_decreasing_time(recording: Recording) -> Recording:
    return replace(recording, time=recording.time[::-1])


def shortened(recording: Recording) -> Recording:
    signals = ("time", "position", "voltage", "repeat")
    return replace(recording, **{name: getattr(recording, name)[:600] for name in signals})


@pytest.mark.parametrize("n", [1, 2, 7, 40])
@pytest.mark.parametrize("method", ["central", "parallel"])
def test_too_few_samples_are_refused(recording: Recording, n: int, method: str) -> None:
    signals = ("time", "position", "voltage", "repeat")
    few = replace(recording, **{name: getattr(recording, name)[1000 : 1000 + n] for name in signals})
    few = replace(few, time=few.time - few.time[0])
    with pytest.raises(BadInput, match=r"expected|constant"):
        prepare(few, method, None)


def with_impossible_angles(recording: Recording) -> Recording:
    return replace(recording, position=recording.position * [6, 6, -6])


UNUSABLE: list[tuple[str, Callable[[Recording], Recording]]] = [
    (
        "joint 2 should move, but its position is constant",
        lambda recording: with_column(recording, "position", 1, 0.3),
    ),
    ("joint 3 should move", lambda recording: with_column(recording, "position", 2, np.nan)),
    ("joint 1 is 0 V throughout", lambda recording: with_column(recording, "voltage", 0, 0.0)),
    ("joint 1 is never received", lambda recording: with_column(recording, "voltage", 0, np.nan)),
    ("interrupted before", interrupted_before_motion),
    (r"made\.mcap: .*check the angles, their zero offsets and the geometry", with_impossible_angles),
    ("time that increases from sample to sample expected, 10 s is followed by 9.998 s", with_decreasing_time),
    ("at least 110 usable samples per joint expected after preprocessing, 16 of 600", shortened),
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


def test_several_recordings_get_a_common_bandwidth(make: Callable[..., Recording]) -> None:
    fine = make(cycles=1, noise=0.01)
    counts = 2**12 / (2 * np.pi)
    coarse = replace(fine, position=np.round(fine.position * counts) / counts)
    both = prepare_all([fine, coarse], "parallel", None)
    alone = prepare(coarse, "parallel", None)
    assert both[0].bandwidth == both[1].bandwidth == alone.bandwidth < prepare_parallel(fine).bandwidth
    assert both[0].rate == both[1].rate
    assert both[0].cutoff == both[1].cutoff


def test_true_motion_and_torque_satisfy_the_model() -> None:
    prepared = prepare(building.record(2), "parallel", building.CUTOFF)
    motion, expected = prepared.as_recorded.motion, building.motion_of(2)
    known = np.isfinite(motion.acceleration)
    for name in ("position", "velocity", "acceleration"):
        error = (getattr(motion, name) - getattr(expected, name))[known]
        assert np.abs(error).max() < 0.02 * np.abs(getattr(expected, name)).max()
    residual = prepared.torque - prepared.condition(prepared.as_recorded.regressor) @ building.parameters(2)
    assert np.nanstd(residual) < 0.01


def test_rows_are_every_so_many_instants() -> None:
    prepared = prepare(building.record(), "parallel", building.CUTOFF)
    step = prepared.preprocessed.decimation
    assert len(prepared.instant_time) == len(prepared.recording.time)
    np.testing.assert_allclose(prepared.instant_time[::step], prepared.time)
    assert prepared.condition(np.ones((len(prepared.instant_time), 3))).shape == (len(prepared.time), 3)


def test_conditioning_is_linear_and_keeps_constants() -> None:
    prepared = prepare(building.record(), "parallel", building.CUTOFF)
    x, y = np.random.default_rng(0).normal(size=(2, len(prepared.instant_time), 2))
    combined = prepared.condition(3 * x - y)
    known = np.isfinite(combined)
    np.testing.assert_allclose(combined[known], (3 * prepared.condition(x) - prepared.condition(y))[known], atol=1e-9)
    constant = prepared.condition(np.full_like(x, 2.5))
    np.testing.assert_allclose(constant[np.isfinite(constant)], 2.5)


def test_start_shifts_the_time_and_nothing_else() -> None:
    early, late = (prepare(building.record(), "parallel", building.CUTOFF, start) for start in (0.0, 100.0))
    np.testing.assert_allclose(late.time, early.time + 100)
    np.testing.assert_allclose(late.time, early.time + 100)
    np.testing.assert_array_equal(late.torque, early.torque)


def test_usable_rows_are_those_with_a_torque() -> None:
    recording = building.record()
    assert recording.effort is not None
    recording.effort[500:520] = np.nan
    prepared = prepare(recording, "parallel", building.CUTOFF)
    np.testing.assert_array_equal(prepared.usable, np.isfinite(prepared.torque))
    row = 510 // prepared.preprocessed.decimation
    assert not prepared.usable[row].any()
    assert prepared.usable[2 * row].all()


def test_correction_of_positions_is_that_of_the_recording() -> None:
    """A correction by an offset shifts the motion; one by a factor scales it."""
    prepared = prepare(building.record(), "parallel", building.CUTOFF)
    rig = prepared.as_recorded.rig
    same, shifted, doubled = (
        prepared.corrected_motion(rig, change) for change in (lambda q: q, lambda q: q + 0.1, lambda q: 2 * q)
    )
    motion = prepared.as_recorded.motion
    np.testing.assert_allclose(same.motion.velocity, motion.velocity)
    np.testing.assert_allclose(shifted.motion.position, motion.position + 0.1)
    np.testing.assert_allclose(shifted.motion.acceleration, motion.acceleration, atol=1e-6)
    np.testing.assert_allclose(doubled.motion.acceleration, 2 * motion.acceleration, atol=1e-6)


def test_load_of_effects_is_the_torque_without_friction() -> None:
    prepared = prepare(building.record(), "parallel", building.CUTOFF)
    corrected = prepared.as_recorded
    inputs = corrected.effect_inputs(building.RATE, prepared.instant_time, building.CUTOFF, building.parameters())
    load, acceleration = inputs.rigid_at(corrected.motion), corrected.motion.acceleration
    known = np.isfinite(load)
    assert known.mean() > 0.9
    np.testing.assert_allclose(load[known], building.INERTIA * acceleration[known])


def test_mechanism_is_that_of_the_rig() -> None:
    prepared = prepare(building.record(2), "parallel", building.CUTOFF)
    assert prepared.as_recorded.mechanism.parameters == mechanisms.create(building.bench(2)).parameters


def test_positions_are_replaced_without_a_cutoff_too() -> None:
    prepared = prepare(building.record(), "central", None)
    shifted = prepared.with_positions(lambda position: position + 0.1)
    assert prepared.cutoff is None
    np.testing.assert_allclose(
        shifted.as_recorded.motion.position, prepared.as_recorded.motion.position + 0.1, atol=1e-12
    )

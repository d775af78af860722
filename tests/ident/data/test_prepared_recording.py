from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ident.data import prepared_recording
from ident.data.prepared_recording import PreparedRecording, prepare, prepare_all
from recordings.errors import BadInput
from recordings.recording import Recording


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

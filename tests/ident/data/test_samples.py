"""Uniform grids from uniform, incomplete and non-uniform time stamps."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.data.samples import drive_signal, holds_torque, sample
from recordings.errors import BadInput
from recordings.imported import imported_rig, measured_torque
from recordings.recording import Floats, Recording, Run


def imported(time: Floats, rate: float = 100.0, effort: bool = True) -> Recording:
    """An imported recording of one axis that moves as sin(3 t)."""
    position = np.sin(3 * time)[:, None]
    signal = np.cos(3 * time)[:, None]
    n, unknown = len(time), np.full((len(time), 1), np.nan)
    zeros = np.zeros((n, 1), np.int64)
    return Recording(
        path=Path("bench.mcap"),
        rig=imported_rig("bench", 1, rate, torque=measured_torque(1)),
        run=Run(
            trajectory="imported",
            trajectory_digest="",
            period=0.0,
            cycles=0,
            rate=rate,
            software="0",
            simulated=False,
            pace="realtime",
            start="1970-01-01T00:00:00Z",
            exit_status=0,
        ),
        time=time,
        position=position,
        command=unknown,
        voltage=unknown if effort else signal,
        velocity=None,
        effort=signal if effort else None,
        statusword=zeros,
        error_code=zeros,
        repeat=np.full(n, -1),
        lateness=unknown[:, 0],
        events=(),
    )


@given(st.integers(0, 10**6), st.floats(0.12, 0.4))
def test_non_uniform_samples_are_interpolated_to_a_uniform_grid(seed: int, jitter: float) -> None:
    time = np.arange(400) / 100 + np.random.default_rng(seed).uniform(-jitter, jitter, 400) / 100
    time -= time[0]
    samples = sample(imported(time))
    grid = np.arange(len(samples.position)) / samples.rate
    assert samples.rate == pytest.approx(100, rel=0.1)
    known = np.isfinite(samples.position[:, 0])
    assert known.mean() > 0.98
    np.testing.assert_allclose(samples.position[known, 0], np.sin(3 * grid[known]), atol=1e-5)
    np.testing.assert_allclose(samples.torque[known, 0], np.cos(3 * grid[known]), atol=1e-5)


def test_long_gaps_are_not_interpolated() -> None:
    time = np.delete(np.arange(400) / 100 + np.tile([0.0, 0.002], 200), [100, *range(200, 204)])
    samples = sample(imported(time))
    grid = np.arange(len(samples.position)) / samples.rate
    unknown = grid[np.isnan(samples.position[:, 0])]
    assert len(unknown) > 0
    # One lost sample is interpolated, four in a row are not.
    assert ((unknown > time[198]) & (unknown < time[200])).all()


def test_a_gap_in_one_signal_is_a_gap_in_that_signal() -> None:
    recording = imported(np.arange(400) / 100 + np.tile([0.0, 0.002], 200))
    assert recording.effort is not None
    recording.effort[100:110] = np.nan
    samples = sample(recording)
    assert np.isnan(samples.torque).any()
    assert np.isfinite(samples.position).all()


def test_effort_is_used_as_torque_unless_there_is_a_voltage() -> None:
    time = np.arange(300) / 100
    recording = imported(time)
    assert holds_torque(recording)
    np.testing.assert_array_equal(sample(recording).torque, recording.effort)
    assert (sample(recording).slope == 1).all()
    with_voltage = replace(recording, voltage=2 * np.cos(3 * time)[:, None])
    assert not holds_torque(with_voltage)
    assert drive_signal(with_voltage) is with_voltage.voltage


def test_rest_before_and_after_a_motion_without_cycles_is_not_selected() -> None:
    time = np.arange(600) / 100
    recording = imported(time)
    recording.position[:, 0] = np.sin(np.clip(time - 1, 0, 3))
    selected = sample(recording).selected
    assert time[selected][[0, -1]].tolist() == pytest.approx([1.01, 4.0], abs=0.15)
    assert selected[120:380].all()
    marked = replace(recording, repeat=np.repeat([-1, 0], [50, 550]))
    assert np.flatnonzero(sample(marked).selected)[[0, -1]].tolist() == [50, 599]


def test_time_that_runs_backwards_is_refused() -> None:
    time = np.arange(300) / 100
    time[[100, 101]] = time[[101, 100]]
    with pytest.raises(BadInput, match=r"1\.01 s is followed by 1 s"):
        sample(imported(time))


@pytest.mark.parametrize(("value", "reading"), [(0.0, "0 N m throughout"), (np.nan, "never received")])
def test_a_constant_drive_signal_is_refused(value: float, reading: str) -> None:
    recording = imported(np.arange(300) / 100)
    assert recording.effort is not None
    recording.effort[:] = value
    recording = recording if np.isfinite(value) else replace(recording, effort=None)
    with pytest.raises(BadInput, match=f"of joint 1 is {reading}"):
        sample(recording)


def delayed(delay: float, lost: list[int]) -> Recording:
    """A recording whose positions are measured `delay` [s] after their SYNC, with the delays recorded."""
    recording = imported(np.arange(400) / 100)
    recording.position[:, 0] = np.sin(3 * (recording.time + delay))
    recording.position[lost] = np.nan
    delays = np.where(np.isnan(recording.position[:, 0]), np.nan, delay)
    return replace(recording, extra={"position_delay_1": delays})


@given(st.floats(-0.002, 0.009), st.lists(st.integers(5, 390), max_size=3))
def test_delayed_positions_are_interpolated_to_the_instants(delay: float, lost: list[int]) -> None:
    samples = sample(delayed(delay, lost))
    known = np.isfinite(samples.position[:, 0])
    np.testing.assert_allclose(samples.position[known, 0], np.sin(3 * np.arange(400)[known] / 100), atol=1e-5)
    # Instants next to a lost sample and at the ends are unknown.
    assert known.sum() >= 400 - len(lost) * 2 - 2
    np.testing.assert_allclose(samples.torque[:, 0], np.cos(3 * np.arange(400) / 100), atol=1e-12)


@given(st.floats(0.0, 0.025), st.booleans(), st.lists(st.integers(5, 390), max_size=3))
def test_torque_that_is_older_than_its_position_is_taken_at_its_instant(
    age: float, uniform: bool, lost: list[int]
) -> None:
    time = np.arange(400) / 100 + (0.0 if uniform else np.random.default_rng(1).uniform(-0.003, 0.003, 400))
    recording = imported(time - time[0])
    assert recording.effort is not None
    recording.effort[:, 0] = np.cos(3 * (recording.time - age))
    recording.effort[lost] = np.nan
    samples = sample(replace(recording, run=recording.run.model_copy(update={"torque_age": age})))
    known = np.isfinite(samples.torque[:, 0])
    instants = np.arange(len(known)) / samples.rate
    np.testing.assert_allclose(samples.torque[known, 0], np.cos(3 * instants[known]), atol=2e-5)
    assert known.sum() >= len(known) - 10 * len(lost) - 10


def test_delays_of_only_some_joints_are_ignored() -> None:
    recording = replace(imported(np.arange(300) / 100), extra={"position_delay_2": np.full(300, 0.005)})
    np.testing.assert_array_equal(sample(recording).position, recording.position)


@pytest.mark.parametrize("step", [1.0, 0.976, 4.0])
def test_time_in_milliseconds_is_refused(step: float) -> None:
    with pytest.raises(BadInput, match=r"check that time is in seconds, and not in milliseconds"):
        sample(imported(np.arange(2000) * step, rate=1 / step))


@pytest.mark.parametrize(("quantity", "value"), [("position", 1e160), ("effort", -1e200), ("voltage", 1e160)])
def test_values_that_no_joint_has_are_refused(quantity: str, value: float) -> None:
    recording = imported(np.arange(300) / 100, effort=quantity != "voltage")
    getattr(recording, quantity)[123] = value
    with pytest.raises(BadInput, match=rf"bench.mcap: {quantity} within .* of joint 1 at 1\.23 s found; check"):
        sample(recording)

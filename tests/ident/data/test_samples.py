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


def test_long_gaps_are_not_interpolated_in_the_signal_that_has_them() -> None:
    """One lost sample is interpolated, four in a row are not."""
    time = np.delete(np.arange(400) / 100 + np.tile([0.0, 0.002], 200), [100, *range(200, 204)])
    recording = imported(time)
    assert recording.effort is not None
    recording.effort[300:310] = np.nan
    samples = sample(recording)
    grid = np.arange(len(samples.position)) / samples.rate
    unknown, silent = (grid[np.isnan(signal[:, 0])] for signal in (samples.position, samples.torque))
    assert len(unknown) > 0
    assert ((unknown > time[198]) & (unknown < time[200])).all()
    assert len(silent) > len(unknown)


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


@given(st.floats(-0.002, 0.009), st.lists(st.integers(5, 390), max_size=3))
def test_delayed_positions_are_interpolated_to_the_instants(delay: float, lost: list[int]) -> None:
    """Positions are measured `delay` [s] after their SYNC, with the delays recorded."""
    recording = imported(np.arange(400) / 100)
    recording.position[:, 0] = np.sin(3 * (recording.time + delay))
    recording.position[lost] = np.nan
    delays = np.where(np.isnan(recording.position[:, 0]), np.nan, delay)
    samples = sample(replace(recording, extra={"position_delay_1": delays}))
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


def with_value(quantity: str, row: int | slice, value: float) -> Recording:
    recording = imported(np.arange(300) / 100, effort=quantity != "voltage")
    getattr(recording, quantity)[row] = value
    return recording


MILLISECONDS = r"check that time is in seconds, and not in milliseconds"
IMPOSSIBLE = r"bench.mcap: {} within .* of joint 1 at 1\.23 s found; check"


@pytest.mark.parametrize(
    ("recording", "reason"),
    [
        (imported(np.array([0.0, 0.01, 0.03, 0.02, *np.arange(4, 300) / 100])), r"0\.03 s is followed by 0\.02 s"),
        (with_value("effort", slice(None), 0.0), "of joint 1 is 0 N m throughout"),
        (replace(imported(np.arange(300) / 100), effort=None), "of joint 1 is never received"),
        *((imported(np.arange(2000) * step, rate=1 / step), MILLISECONDS) for step in (1.0, 0.976, 4.0)),
        (with_value("position", 123, 1e160), IMPOSSIBLE.format("position")),
        (with_value("effort", 123, -1e200), IMPOSSIBLE.format("effort")),
        (with_value("voltage", 123, 1e160), IMPOSSIBLE.format("voltage")),
    ],
)
def test_recordings_that_cannot_be_true_are_refused(recording: Recording, reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        sample(recording)

"""Even grids from even, lossy and uneven time stamps."""

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
    """One axis that moves as sin(3 t), imported from elsewhere."""
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
def test_uneven_samples_are_brought_onto_an_even_grid(seed: int, jitter: float) -> None:
    time = np.arange(400) / 100 + np.random.default_rng(seed).uniform(-jitter, jitter, 400) / 100
    time -= time[0]
    found = sample(imported(time))
    grid = np.arange(len(found.position)) / found.rate
    assert found.rate == pytest.approx(100, rel=0.1)
    known = np.isfinite(found.position[:, 0])
    assert known.mean() > 0.98
    np.testing.assert_allclose(found.position[known, 0], np.sin(3 * grid[known]), atol=1e-5)
    np.testing.assert_allclose(found.torque[known, 0], np.cos(3 * grid[known]), atol=1e-5)


def test_nothing_is_invented_in_a_hole() -> None:
    time = np.delete(np.arange(400) / 100 + np.tile([0.0, 0.002], 200), [100, *range(200, 204)])
    found = sample(imported(time))
    grid = np.arange(len(found.position)) / found.rate
    unknown = grid[np.isnan(found.position[:, 0])]
    assert len(unknown) > 0
    # One lost sample is bridged, four in a row are not.
    assert ((unknown > time[198]) & (unknown < time[200])).all()


def test_a_gap_in_one_signal_is_a_gap_in_that_signal() -> None:
    made = imported(np.arange(400) / 100 + np.tile([0.0, 0.002], 200))
    assert made.effort is not None
    made.effort[100:110] = np.nan
    found = sample(made)
    assert np.isnan(found.torque).any()
    assert np.isfinite(found.position).all()


def test_measured_effort_is_the_torque_and_voltage_goes_before_it() -> None:
    time = np.arange(300) / 100
    made = imported(time)
    assert holds_torque(made)
    np.testing.assert_array_equal(sample(made).torque, made.effort)
    assert (sample(made).slope == 1).all()
    both = replace(made, voltage=2 * np.cos(3 * time)[:, None])
    assert not holds_torque(both)
    assert drive_signal(both) is both.voltage


def test_rest_before_and_after_an_unmarked_motion_is_not_wanted() -> None:
    time = np.arange(600) / 100
    made = imported(time)
    made.position[:, 0] = np.sin(np.clip(time - 1, 0, 3))
    wanted = sample(made).selected
    assert time[wanted][[0, -1]].tolist() == pytest.approx([1.01, 4.0], abs=0.15)
    assert wanted[120:380].all()
    marked = replace(made, repeat=np.repeat([-1, 0], [50, 550]))
    assert np.flatnonzero(sample(marked).selected)[[0, -1]].tolist() == [50, 599]


def test_time_that_runs_backwards_is_refused() -> None:
    time = np.arange(300) / 100
    time[[100, 101]] = time[[101, 100]]
    with pytest.raises(BadInput, match=r"1\.01 s is followed by 1 s"):
        sample(imported(time))


@pytest.mark.parametrize(("value", "found"), [(0.0, "0 N m throughout"), (np.nan, "never received")])
def test_a_drive_that_gives_nothing_is_refused(value: float, found: str) -> None:
    made = imported(np.arange(300) / 100)
    assert made.effort is not None
    made.effort[:] = value
    made = made if np.isfinite(value) else replace(made, effort=None)
    with pytest.raises(BadInput, match=f"of joint 1 is {found}"):
        sample(made)


def delayed(delay: float, lost: list[int]) -> Recording:
    """Every value measured by so much later than its SYNC [s], and told to be."""
    made = imported(np.arange(400) / 100)
    made.position[:, 0] = np.sin(3 * (made.time + delay))
    made.position[lost] = np.nan
    told = np.where(np.isnan(made.position[:, 0]), np.nan, delay)
    return replace(made, extra={"position_delay_1": told})


@given(st.floats(-0.002, 0.009), st.lists(st.integers(5, 390), max_size=3))
def test_what_was_measured_later_is_brought_back_to_the_instant(delay: float, lost: list[int]) -> None:
    found = sample(delayed(delay, lost))
    known = np.isfinite(found.position[:, 0])
    np.testing.assert_allclose(found.position[known, 0], np.sin(3 * np.arange(400)[known] / 100), atol=1e-5)
    # Where a sample was lost, the instant between its neighbours is not known; nor are those at the very ends.
    assert known.sum() >= 400 - len(lost) * 2 - 2
    np.testing.assert_allclose(found.torque[:, 0], np.cos(3 * np.arange(400) / 100), atol=1e-12)


def test_delays_of_some_joints_only_are_numbers_of_another_program() -> None:
    made = replace(imported(np.arange(300) / 100), extra={"position_delay_2": np.full(300, 0.005)})
    np.testing.assert_array_equal(sample(made).position, made.position)


@pytest.mark.parametrize("step", [1.0, 0.976, 4.0])
def test_time_in_milliseconds_is_refused(step: float) -> None:
    with pytest.raises(BadInput, match=r"check that time is in seconds, and not in milliseconds"):
        sample(imported(np.arange(2000) * step, rate=1 / step))

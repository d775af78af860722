"""Cycle detection in motions with known repetitions and in motions without."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.cycles import Cycles, find_cycles
from recordings.reader import read

SAMPLES = Path(__file__).parents[2] / "recordings" / "samples"


def fourier(rng: np.random.Generator, period: int, joints: int) -> np.ndarray:
    """(period, joints) one cycle of a smooth motion."""
    phase = 2 * np.pi * np.arange(period)[:, None] / period
    return sum(rng.normal(size=joints) * np.sin(k * phase + rng.uniform(0, 6, size=joints)) / k for k in range(1, 6))


@given(
    seed=st.integers(0, 1000),
    period=st.integers(60, 700),
    count=st.integers(2, 9),
    joints=st.integers(1, 3),
    rest=st.tuples(st.integers(0, 3000), st.integers(0, 3000)),
)
@settings(deadline=None, max_examples=25)
def test_exact_repetition_is_found_to_the_sample(
    seed: int, period: int, count: int, joints: int, rest: tuple[int, int]
) -> None:
    cycle = fourier(np.random.default_rng(seed), period, joints)
    # Complete cycles between rests: the repeated part is exactly the tiled part.
    x = np.concatenate(
        [np.repeat(cycle[:1] - 1, rest[0], 0), np.tile(cycle, (count, 1)), np.repeat(cycle[:1] - 1, rest[1], 0)]
    )
    assert find_cycles(x) == Cycles(rest[0], period, count)


@pytest.mark.parametrize(("name", "tolerance"), [("fig5a", 5), ("fig5b", 5)])
def test_cycles_of_a_recording_with_approach_and_stop_are_found(name: str, tolerance: int) -> None:
    recording = read(SAMPLES / f"{name}.mcap")
    period = round(recording.run.period * recording.run.rate)
    first = int(np.argmax(recording.repeat == 0))
    repeats = (recording.command[:-period] == recording.command[period:]).all(axis=1)
    # The end of the approach may be equal to that of the cycle.
    begin = first - int(np.argmin(repeats[first - 1 :: -1]))
    assert find_cycles(recording.command) == Cycles(begin, period, 2)
    rng = np.random.default_rng(0)
    measured = recording.position + rng.normal(scale=1e-4, size=recording.position.shape)
    cycles = find_cycles(measured)
    assert (cycles.period, cycles.count) == (period, 2)
    assert first - 150 < cycles.first <= first + tolerance
    rounded = find_cycles(recording.position)  # all but the first samples of the cycles are equal to the count
    assert (rounded.period, rounded.count) == (period, 2)


@pytest.mark.parametrize("decimals", range(3, 9))
def test_cycles_are_found_where_the_first_one_settles_and_somebody_rounded_again(decimals: int) -> None:
    """What is left of the approach moves the readings of an encoder by a step, until it has faded."""
    rng, step = np.random.default_rng(1), 2 * np.pi / 2**17
    cycle = fourier(rng, 1000, 3)
    x = np.concatenate([cycle[:1] * np.linspace(0, 1, 200)[:, None], np.tile(cycle, (3, 1)), cycle[:120]])
    x[200:] += 0.003 * np.exp(-np.arange(3120) / 40)[:, None]
    cycles = find_cycles((np.floor(x / step) * step).round(decimals))
    assert (cycles.period, cycles.count) == (1000, 3)
    assert abs(cycles.first - 200) < 150


def test_cycles_are_found_despite_gaps() -> None:
    rng = np.random.default_rng(1)
    x = np.tile(fourier(rng, 400, 2), (5, 1))
    x[rng.random(len(x)) < 0.02] = np.nan
    cycles = find_cycles(x)
    assert (cycles.period, cycles.count) == (400, 5)


def test_joint_that_was_measured_only_before_the_motion_hides_no_cycles() -> None:
    x = np.tile(fourier(np.random.default_rng(2), 200, 2), (5, 1))
    x = np.concatenate([np.repeat(x[:1], 300, 0), x])
    x[:200, 1] += np.linspace(0, 1e-9, 200)
    x[290:, 1] = np.nan
    assert find_cycles(x) == Cycles(300, 200, 5)


@pytest.mark.parametrize(
    "motion",
    [
        np.zeros((500, 2)),
        np.full((500, 2), np.nan),
        np.zeros((500, 0)),
        np.arange(500.0)[:, None],
        np.cumsum(np.random.default_rng(1).normal(size=(5000, 3)), axis=0),
        np.exp(-np.arange(5000.0) / 500)[:, None] * np.sin(np.arange(5000) / 50)[:, None],
        np.sin((np.arange(5000) / 300) ** 2)[:, None],
        np.ones((1, 1)),
    ],
    ids=["rest", "unknown", "no joints", "ramp", "random walk", "dying out", "chirp", "one sample"],
)
def test_motion_without_repetition_has_no_cycles(motion: np.ndarray) -> None:
    assert find_cycles(motion) is None


def test_of_a_faster_repetition_several_are_one_cycle() -> None:
    assert find_cycles(np.sin(2 * np.pi * np.arange(400)[:, None] / 7)) == Cycles(0, 21, 19)

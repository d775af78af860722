"""Noise from the differences between cycles, with and without an event."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Generator
from scipy.signal import lfilter

from ident.data.cycle_differences import (
    cycle_differences,
    degrees_of_freedom,
    deviation_within_groups,
)
from recordings.recording import Floats

PHASES = 400
PHASE = np.arange(PHASES) / PHASES


def noise(rng: Generator, cycles: int, correlation: float) -> Floats:
    """(cycles, PHASES) of variance one, first-order autoregressive along the phase."""
    white = rng.normal(size=(cycles, PHASES + 200))
    return np.asarray(lfilter([np.sqrt(1 - correlation**2)], [1, -correlation], white))[:, 200:]


def with_event(rng: Generator, cycles: int, instant: float, size: float) -> Floats:
    """Noise, and from an `instant` [cycles] on a torque of RMS `size` that repeats with the motion."""
    after = np.arange(cycles)[:, None] + PHASE >= instant
    return noise(rng, cycles, 0.5) + size * np.sqrt(2) * np.sin(6 * np.pi * PHASE + 1) * after


@pytest.mark.parametrize("cycles", [2, 3, 5, 10])
@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_noise_is_unbiased(cycles: int, correlation: float) -> None:
    rng = np.random.default_rng([cycles, round(10 * correlation)])
    draws = [cycle_differences(noise(rng, cycles, correlation)) for _ in range(300)]
    assert np.mean([draw.noise for draw in draws if draw]) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("cycles", [3, 5, 10])
@pytest.mark.parametrize("size", [0.3, 3.0, 30.0])
def test_event_at_any_instant_is_no_noise(cycles: int, size: float) -> None:
    rng = np.random.default_rng(cycles)
    instants = [*range(1, cycles), cycles / 2, *rng.uniform(0.1, cycles - 0.1, 40)]
    levels = [cycle_differences(with_event(rng, cycles, instant, size)).noise for instant in instants]  # type: ignore[union-attr]
    assert np.median(levels) == pytest.approx(1.0, abs=0.25)
    if cycles > 3:  # with three, both differences are disturbed where the block of the event ends
        assert max(levels) < 2.0


@given(
    seed=st.integers(0, 2**32 - 1),
    cycles=st.integers(2, 6),
    phases=st.integers(1, 120),
    lost=st.floats(0, 0.95),
    scale=st.sampled_from([0.0, 1e-9, 1.0, 1e9]),
)
def test_any_recording_has_a_noise_or_none(seed: int, cycles: int, phases: int, lost: float, scale: float) -> None:
    """Gaps of any kind, and jumps at any place."""
    rng = np.random.default_rng(seed)
    x = scale * (rng.normal(size=(cycles, phases)) + 100 * (rng.random((cycles, phases)) < rng.random() ** 3))
    gaps = np.repeat(rng.random((cycles, -(-phases // 5))) < lost, 5, axis=1)[:, :phases]
    x[gaps] = np.nan
    differences = cycle_differences(x)
    assert (differences is None) == (not np.isfinite(np.diff(x, axis=0)).any())
    if differences:
        assert 0 <= differences.noise < np.inf
        assert differences.freedom >= 1
        assert differences.values.shape == (cycles - 1, phases)
        assert np.isfinite(deviation_within_groups(x, differences)[0][np.isfinite(x)]).mean() <= 1


def test_only_the_differences_that_the_event_touches_are_left_out() -> None:
    differences = cycle_differences(with_event(np.random.default_rng(0), 5, 2.5, 10.0))
    assert differences is not None
    known = np.isfinite(differences.values)
    assert known.shape == (4, PHASES)
    assert known[[0, 3]].all()
    assert not known[1, PHASES * 6 // 10 :].any()  # those from the second cycle to the third change at the end
    assert not known[2, : PHASES * 4 // 10].any()
    assert known[1, : PHASES * 4 // 10].all()


@pytest.mark.parametrize("instant", [1, 2])
def test_deviation_is_from_the_mean_of_the_cycles_before_or_after_the_event(instant: int) -> None:
    """A cycle that stands alone has none."""
    x = with_event(np.random.default_rng(0), 5, instant, 30.0)
    differences = cycle_differences(x)
    assert differences is not None
    deviation, groups = deviation_within_groups(x, differences)
    before, after = (part - part.mean(axis=0) for part in (x[:instant], x[instant:]))
    disturbed = np.isnan(differences.values[instant - 1])
    expected = np.concatenate([before if instant > 1 else np.full_like(before, np.nan), after])
    np.testing.assert_allclose(deviation[:, disturbed], expected[:, disturbed])
    assert disturbed.mean() > 0.9
    assert instant == 1 or groups == PHASES + disturbed.sum()


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_degrees_of_freedom_are_those_of_the_autocorrelation(correlation: float) -> None:
    expected = PHASES * (1 - correlation**2) / (1 + correlation**2)
    draws = [degrees_of_freedom(noise(np.random.default_rng(seed), 4, correlation)) for seed in range(40)]
    assert np.mean(draws) == pytest.approx(expected, rel=0.15)

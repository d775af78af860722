"""Evidence of a change: rare by chance on any night, not fooled by season, motion or an odd night, and well dated."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import beta

from ident.sequential.change_point import (
    LONGEST,
    MIN_BEFORE,
    Change,
    ChangeProcess,
    alternatives,
    change,
    log_bayes_factors,
    log_kept,
)
from recordings.recording import Floats

NIGHTS = 30
DAY = np.arange(NIGHTS, dtype=float)
MEAN = np.ones((NIGHTS, 1))


def found(y: Floats, nuisance: Floats = MEAN) -> Change:
    result = change(y, DAY[: len(y)], nuisance[: len(y)])
    assert result is not None
    return result


def noise(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=NIGHTS)


def test_bayes_factor_is_a_fair_bet() -> None:
    """Under the null hypothesis the expectation of the ratio is 1, whatever mean and scatter are."""
    n, step = 12, (np.arange(12) >= 7).astype(float)
    along = (step - step.mean()) / np.linalg.norm(step - step.mean())
    across = np.random.default_rng(0).normal(size=n)
    across -= across.mean() + along * (across @ along)
    across /= np.linalg.norm(across)

    def ratio(share: float) -> float:
        """For data of which the step explains this share; the share has a beta distribution."""
        y = 5 + 3 * (np.sqrt(share) * along + np.sqrt(1 - share) * across)
        return float(np.exp(log_bayes_factors(y, np.ones((n, 1)), step[:, None], n)[0]))

    distribution = beta(0.5, (n - 2) / 2)
    expectation = quad(lambda share: ratio(share) * distribution.pdf(share), 0, 1, limit=200)[0]
    assert expectation == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("draw", [lambda rng: rng.normal(size=NIGHTS), lambda rng: rng.standard_t(3, size=NIGHTS)])
def test_chance_gives_no_evidence_even_with_odd_nights(draw: object) -> None:
    rng = np.random.default_rng(1)
    evidence = [found(draw(rng)).log_e for _ in range(20)]  # type: ignore[operator]
    assert max(evidence) < np.log(1000)


@settings(max_examples=20)
@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
def test_evidence_does_not_depend_on_unit_or_origin(shift: float, scale: float) -> None:
    y = noise(2) + 4 * (DAY >= 18)
    assert found(scale * y + shift).log_e == pytest.approx(found(y).log_e, rel=1e-6)


def test_step_is_dated() -> None:
    y = noise(3) + 6 * (DAY >= 18)
    result = found(y)
    assert result.log_e > np.log(1e5)
    assert not result.growing
    assert result.index == 18
    assert result.first <= 18 <= result.last
    assert result.size == pytest.approx(6, abs=4 * result.size_std)


def test_growth_is_told_from_a_step() -> None:
    y = 0.3 * noise(4) + 0.3 * np.maximum(DAY - 12, 0)
    result = found(y)
    assert result.log_e > np.log(1e5)
    assert result.growing
    assert abs(result.index - 13) <= 2
    assert result.size == pytest.approx(0.3 * 17, rel=0.2)


def test_season_and_motion_explain_what_follows_them() -> None:
    temperature = 10 * np.sin(DAY / 15)
    motion = (DAY >= 20).astype(float)
    y = 0.2 * noise(5) + temperature + 8 * motion
    columns = np.column_stack([1 - motion, motion, temperature])
    assert found(y).log_e > np.log(100)
    assert found(y, columns).log_e < np.log(20)


def test_odd_night_is_forgotten() -> None:
    y = noise(6)
    y[20] += 30
    assert found(y).log_e < np.log(100)


def test_nights_that_resemble_each_other_count_less() -> None:
    y = np.cumsum(noise(7))
    assert found(y).log_e < np.log(1e5)


def test_few_nights_and_constant_values_say_nothing() -> None:
    assert change(np.arange(7.0), DAY[:7], MEAN[:7]) is None
    assert found(np.full(NIGHTS, 3.0)).log_e < 0


@given(st.floats(0, 700))
def test_kept_value_is_less_than_the_largest(log_m: float) -> None:
    assert log_kept(log_m) <= max(log_m, 0.0)


@settings(max_examples=5)
@given(st.integers(0, 2**32 - 1))
def test_evidence_of_a_night_is_that_of_all_nights_until_then(seed: int) -> None:
    """Though only the last ones are kept: by the ratios of likelihoods of all rows."""
    rng = np.random.default_rng(seed)
    n, motion = LONGEST + 40, rng.integers(0, 2, LONGEST + 40)
    nuisance = np.column_stack([rng.normal(20, 5, n), np.ones(n), motion])
    y, process = nuisance @ [0.1, 1.0, 2.0] + rng.normal(size=n), ChangeProcess()
    for night in range(n):
        process.observe(y[night], float(night), nuisance[night, : 2 + motion[night]].tolist())
    begin = np.arange(n - LONGEST, n)
    columns = alternatives(np.arange(float(n)), begin).reshape(n, -1)
    factors = log_bayes_factors(y, nuisance, columns, n).reshape(2, -1)
    number = begin - MIN_BEFORE
    mixed = np.logaddexp(*factors) - np.log(2) - np.log((number + 1.0) * (number + 2))
    expected = np.logaddexp(np.logaddexp.reduce(mixed), -np.log(n - MIN_BEFORE + 1))
    assert process.tonight[-1] == pytest.approx(expected, abs=1e-6)


def test_long_series_is_searched_over_its_last_nights() -> None:
    nights = LONGEST + 60
    y = np.random.default_rng(8).normal(size=nights) + 6 * (np.arange(nights) >= nights - 20)
    result = change(y, np.arange(float(nights)), np.ones((nights, 1)))
    assert result is not None
    assert (result.index, result.growing, result.seen) == (nights - 20, False, nights)
    early = y[::-1].copy()
    result = change(early, np.arange(float(nights)), np.ones((nights, 1)))
    assert result is not None
    assert (result.index, result.log_e > np.log(1e5)) == (20, True)

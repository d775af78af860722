import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.basics import filters

RATES = st.floats(100, 2000)


@given(rate=RATES, share=st.floats(0.01, 0.2))
def test_low_pass_is_3_db_down_at_the_cutoff(rate: float, share: float) -> None:
    taps = filters.low_pass(share * rate, rate)
    response = taps @ np.exp(-2j * np.pi * share * np.arange(len(taps)))
    assert 20 * np.log10(abs(response)) == pytest.approx(-3.0103, abs=1e-4)
    assert taps.sum() == pytest.approx(1)


@given(share=st.floats(0.01, 0.2))
def test_low_pass_stops_everything_above_twice_the_cutoff(share: float) -> None:
    taps = filters.low_pass(share, 1.0)
    above = np.arange(2 * share, 0.5, 0.002)
    response = np.exp(-2j * np.pi * np.outer(above, np.arange(len(taps)))) @ taps
    assert abs(response).max() < 2e-3


@given(n=st.integers(30, 60), step=st.integers(1, 7), gap=st.integers(0, 29), seed=st.integers(0, 99))
def test_convolution_is_centred_and_a_gap_affects_only_its_window(n: int, step: int, gap: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, taps = rng.normal(size=(n, 2)), rng.normal(size=5)
    x[gap, 1] = np.nan
    out = filters.convolve(x, taps, step)
    expected = np.full((n, 2), np.nan)
    for column in range(2):
        expected[2:-2, column] = np.convolve(x[:, column], taps, "valid")
    np.testing.assert_allclose(out, expected[::step], rtol=1e-9, atol=1e-12)
    assert np.isnan(out[:, 1]).sum() - np.isnan(out[:, 0]).sum() <= 5


def test_derivatives_are_exact_for_polynomials_of_degree_eight() -> None:
    rate = 50.0
    t = np.arange(40) / rate - 0.4
    polynomial = np.polynomial.Polynomial([1, -2, 0.5, 3, -1, 2, 1, -0.5, 0.3])
    x = polynomial(t)[:, None]
    inner = slice(4, -4)
    first, second = filters.first_derivative(x, rate), filters.second_derivative(x, rate)
    np.testing.assert_allclose(first[inner, 0], polynomial.deriv()(t)[inner], rtol=1e-9)
    np.testing.assert_allclose(second[inner, 0], polynomial.deriv(2)(t)[inner], rtol=1e-8)
    assert np.isnan(first[:4]).all()
    assert np.isnan(second[-4:]).all()


@given(
    instant=st.floats(3.0, 6.0), slope=st.floats(0.1, 10), sign=st.sampled_from([-1, 1]), window=st.floats(0.05, 1.0)
)
def test_sgn_is_averaged_over_the_window_of_a_reversal(
    instant: float, slope: float, sign: int, window: float
) -> None:
    sample = np.arange(10)
    velocity = sign * slope * (sample - instant)
    # From k - window / 2 to k + window / 2 the sign changes at the reversal.
    expected = sign * np.clip(2 * (sample - instant) / window, -1, 1)
    np.testing.assert_allclose(filters.mean_sign(velocity[:, None], window)[1:-1, 0], expected[1:-1], atol=1e-12)


def test_sgn_at_rest_is_zero() -> None:
    assert (filters.mean_sign(np.zeros((5, 1)))[1:-1] == 0).all()

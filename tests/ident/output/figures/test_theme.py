import numpy as np
import pytest

from ident.output import digits
from ident.output.figures import theme


def test_thinning_keeps_peaks_gaps_and_a_slice() -> None:
    n = 100_000
    x = np.arange(n) / 500.0
    y = np.sin(x)
    y[12_345], y[77_777] = 9.0, -9.0
    y[50_000:50_500] = np.nan
    thin_x, thin_y = theme.thinned(x, y, 2000, kept=slice(500, 700))
    assert set(x[500:700]) <= set(thin_x)
    assert len(thin_x) <= 3300
    assert np.nanmax(thin_y) == 9.0
    assert np.nanmin(thin_y) == -9.0
    assert np.isnan(thin_y).any()
    assert (np.diff(thin_x) > 0).all()


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (12345.6, "12346"),
        (3.14159, "3.14"),
        (0.00034567, "0.000346"),
        (9.999, "10.0"),
        (1.2345e-9, "1.23e-09"),
        (None, "–"),
        (float("nan"), "–"),
    ],
)
def test_numbers_have_three_digits(value: float | None, shown: str) -> None:
    assert digits.number(value) == shown


def test_numbers_side_by_side_have_equal_decimals() -> None:
    assert digits.with_equal_decimals([0.0413, 0.000067]) == ["0.041", "0.000"]
    assert digits.with_equal_decimals([0.0, 0.0]) == ["0", "0"]


@pytest.mark.parametrize(
    ("share", "shown"),
    [(0.734, "73 %"), (0.0123, "1.2 %"), (0.997, "99.7 %"), (0.9999, "> 99.9 %"), (1.0, "100 %"), (0.0, "0 %")],
)
def test_percent(share: float, shown: str) -> None:
    assert digits.percent(share).replace("\u00a0", " ") == shown


def test_intervals_have_the_digits_of_their_width() -> None:
    assert digits.interval(14.00236, 14.01171) == "14.0024 to 14.0117"
    assert digits.interval(-0.1434, -0.0961) == "-0.143 to -0.096"
    assert digits.interval(2.0, 2.0) == "2.00 to 2.00"

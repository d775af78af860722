import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.delay_line import DelayLine

DT = 2e-4


@given(delay=st.floats(0.0, 0.01))
def test_ramp_is_delayed(delay: float) -> None:
    line = DelayLine(delay, DT)
    out = [line.push(k * DT) for k in range(100)]
    assert out[60:] == pytest.approx([k * DT - delay for k in range(60, 100)], abs=1e-12)


def test_zero_delay_returns_the_samples() -> None:
    line = DelayLine(0.0, DT)
    assert [line.push(value) for value in (1.0, -2.5, 3.0)] == [1.0, -2.5, 3.0]


def test_cleared_delay_line_returns_zero() -> None:
    line = DelayLine(0.001, DT)
    for _ in range(10):
        line.push(7.0)
    line.clear()
    assert line.push(7.0) == 0.0

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.setpoint_generator import SetpointGenerator

DT = 2e-4


def test_interpolation_is_linear_and_ends_on_the_target() -> None:
    generator = SetpointGenerator(DT)
    generator.hold(1.0)
    generator.interpolate(2.0, 10 * DT)
    assert [generator.step() for _ in range(12)] == pytest.approx(
        [1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2, 2, 2]
    )


@given(speed=st.floats(-10, 10), deceleration=st.floats(1, 500))
def test_stop_ends_at_rest_without_reversal(speed: float, deceleration: float) -> None:
    generator = SetpointGenerator(DT)
    generator.interpolate(speed * DT * 10, 10 * DT)
    generator.step()
    before = generator.position
    generator.stop(deceleration)
    steps = 0
    while not generator.at_rest:
        after = generator.step()
        assert (after - before) * speed >= 0
        before = after
        steps += 1
    assert steps <= abs(speed) / deceleration / DT + 2


def test_hold_cancels_a_motion() -> None:
    generator = SetpointGenerator(DT)
    generator.interpolate(1.0, 10 * DT)
    generator.hold(0.5)
    assert generator.at_rest
    assert generator.step() == 0.5

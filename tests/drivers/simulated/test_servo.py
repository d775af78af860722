from collections.abc import Callable

import pytest

from drivers.simulated.config import Servo
from drivers.simulated.servo import PositionLoop

DT = 2e-4
SERVO = Servo()


def _followed(
    setpoint: Callable[[float], float], seconds: float, *, load: float = 0.0, offset: float = 0.0, exact: bool = False
) -> tuple[float, float, float]:
    """Position, torque, and largest error from the setpoint after a motion of an inertia of 0.35 kg m^2."""
    axis, q, v, worst = PositionLoop(SERVO.model_copy(update={"exact_reference": exact}), DT, 10), 0.0, 0.0, 0.0
    axis.restart(0.0)
    for step in range(1, round(seconds / DT) + 1):
        v += (axis.follow(setpoint(step * DT), q, v, offset) - load) / 0.35 * DT
        q += v * DT
        worst = max(worst, abs(q - setpoint(step * DT)))
    return q, axis.torque, worst


@pytest.mark.parametrize("load", [-15.0, 0.0, 15.0])
def test_settles_on_the_setpoint_whatever_the_load(load: float) -> None:
    q, torque, _ = _followed(lambda t: 0.1, 1.0, load=load)
    assert q == pytest.approx(0.1, abs=1e-6)
    assert torque == pytest.approx(load, abs=1e-3)


def test_torque_offset_takes_the_load_off_the_integrator() -> None:
    without, fed = (_followed(lambda t: 0.0, 0.4, load=15.0, offset=offset)[2] for offset in (0.0, 15.0))
    assert fed < 0.1 * without


def test_exact_reference_follows_an_acceleration_with_a_fitting_torque_exactly() -> None:
    ends = [
        _followed(lambda t: 0.5 * 20.0 * t**2, 0.4, offset=0.35 * 20.0, exact=exact)[0] for exact in (False, True)
    ]
    usual, exact = (abs(q - 0.5 * 20.0 * 0.4**2) for q in ends)
    assert exact < 2e-4
    assert exact < 0.2 * usual


def test_torque_stays_within_the_limit_and_does_not_wind_up() -> None:
    axis = PositionLoop(SERVO, DT, 10)
    axis.restart(0.0)
    pushed = [axis.follow(1.0, 0.0, 0.0) for _ in range(1000)]
    assert max(pushed) <= SERVO.torque_limit
    assert pushed[-1] == pytest.approx(SERVO.torque_limit)
    assert [axis.follow(1.0, 1.2, 0.0) for _ in range(50)][-1] < 0.0
    axis.restart(0.5)
    axis.torque = 0.0
    assert axis.follow(0.5, 0.5, 0.0) == 0.0

import math

import pytest

from drivers.simulated.config import Servo
from drivers.simulated.servo import PositionLoop

DT = 2e-4
SERVO = Servo()


def _settled(load: float) -> tuple[float, float]:
    """Position and torque after one second on an inertia with a constant `load`; the setpoint is 0.1 rad."""
    axis, q, v = PositionLoop(SERVO, DT, 10), 0.0, 0.0
    axis.restart(0.0)
    for _ in range(5000):
        v += (axis.follow(0.1, q, v) - load) / 0.35 * DT
        q += v * DT
    return q, axis.torque


@pytest.mark.parametrize("load", [-15.0, 0.0, 15.0])
def test_settles_on_the_setpoint_whatever_the_load(load: float) -> None:
    q, torque = _settled(load)
    assert q == pytest.approx(0.1, abs=1e-6)
    assert torque == pytest.approx(load, abs=1e-3)


def test_torque_offset_takes_the_load_off_the_integrator() -> None:
    axis, errors = PositionLoop(SERVO, DT, 10), []
    for offset in (0.0, 15.0):
        q, v = 0.0, 0.0
        axis.restart(0.0)
        worst = 0.0
        for _ in range(2000):
            v += (axis.follow(0.0, q, v, offset) - 15.0) / 0.35 * DT
            q += v * DT
            worst = max(worst, abs(q))
        errors.append(worst)
    assert errors[1] < 0.1 * errors[0]


def test_exact_reference_follows_an_acceleration_with_a_fitting_torque_exactly() -> None:
    errors = {}
    for exact in (False, True):
        axis, q, v = PositionLoop(SERVO.model_copy(update={"exact_reference": exact}), DT, 10), 0.0, 0.0
        axis.restart(0.0)
        for step in range(1, 2001):
            v += axis.follow(0.5 * 20.0 * (step * DT) ** 2, q, v, 0.35 * 20.0) / 0.35 * DT
            q += v * DT
        errors[exact] = abs(q - 0.5 * 20.0 * (2000 * DT) ** 2)
    assert errors[True] < 2e-4
    assert errors[True] < 0.2 * errors[False]


def test_constant_speed_is_followed_without_lag() -> None:
    axis, q, v, speed = PositionLoop(SERVO, DT, 10), 0.0, 0.0, 3.0
    axis.restart(0.0)
    for step in range(1, 10001):
        v += axis.follow(speed * step * DT, q, v) / 0.35 * DT
        q += v * DT
    assert q == pytest.approx(speed * 10000 * DT, abs=1e-3)


def test_torque_stays_within_the_limit_and_does_not_wind_up() -> None:
    axis = PositionLoop(SERVO, DT, 10)
    axis.restart(0.0)
    pushed = [axis.follow(1.0, 0.0, 0.0) for _ in range(1000)]
    assert max(pushed) <= SERVO.torque_limit
    assert pushed[-1] == pytest.approx(SERVO.torque_limit)
    released = [axis.follow(1.0, 1.2, 0.0) for _ in range(50)]
    assert released[-1] < 0.0


def test_current_decays_with_the_current_loops_time_constant() -> None:
    axis = PositionLoop(SERVO, DT, 10)
    axis.torque = 10.0
    for _ in range(10):
        axis.idle()
    assert axis.torque == pytest.approx(10.0 * (1 - DT / SERVO.current_lag) ** 10)
    assert axis.torque < 10.0 * math.exp(-10 * DT / SERVO.current_lag)


def test_restart_clears_the_loops_memory() -> None:
    axis, fresh = PositionLoop(SERVO, DT, 10), PositionLoop(SERVO, DT, 10)
    for _ in range(100):
        axis.follow(0.3, 0.0, 0.0)
    axis.restart(0.5)
    axis.torque = 0.0
    fresh.restart(0.5)
    assert axis.follow(0.5, 0.5, 0.0) == fresh.follow(0.5, 0.5, 0.0) == 0.0

"""The position loop of one drive, running at the plant's step rate.

It closes on the drive's fine internal angle, not on the counts that the drive reports: real drives interpolate their
encoders' signals, and so quantisation does not rattle through the gains.
"""

from collections import deque

from drivers.simulated.config import Servo


class PositionLoop:
    """Position P, velocity PI with feed-forward, current limit and current loop of one joint."""

    def __init__(self, servo: Servo, dt: float, smoothing: int) -> None:
        """`smoothing`: steps over which setpoints are averaged; one SYNC period, so that straight lines between the
        targets of two SYNCs give a velocity without corners at the SYNC rate."""
        self._position_gain = servo.position_gain
        self._velocity_gain = servo.velocity_gain
        self._integral_gain = servo.velocity_gain / servo.integral_time * dt
        self._limit = servo.torque_limit
        self._current_step = min(dt / servo.current_lag, 1.0)
        self._smoothing, self._window = smoothing, smoothing * dt
        self._setpoints: deque[float] = deque([0.0] * smoothing, maxlen=smoothing)
        self._sum = 0.0
        self._integral = 0.0
        self.torque = 0.0
        """What the current gives [N m]."""

    def restart(self, position: float) -> None:
        """Begin to hold `position` [rad]: what the loop remembers is forgotten."""
        self._setpoints.extend([position] * self._smoothing)
        self._sum = position * self._smoothing
        self._integral = 0.0

    def follow(self, setpoint: float, q: float, v: float) -> float:
        """One step of the closed loop: torque [N m] at the motor's angle q [rad] and speed v [rad/s]."""
        setpoints = self._setpoints
        oldest = setpoints[0]
        setpoints.append(setpoint)
        self._sum += setpoint - oldest
        # The derivative of a moving average is the difference over its window; half a window ahead of the average
        # lies the present.
        v_reference = (setpoint - oldest) / self._window
        reference = self._sum / self._smoothing + 0.5 * self._window * v_reference
        v_error = v_reference + self._position_gain * (reference - q) - v
        wanted = self._velocity_gain * v_error + self._integral
        limit = self._limit
        # Comparisons, where min and max would cost more than the rest of this line.
        limited = limit if wanted > limit else -limit if wanted < -limit else wanted
        if wanted == limited:
            self._integral += self._integral_gain * v_error
        self.torque += self._current_step * (limited - self.torque)
        return self.torque

    def idle(self) -> float:
        """One step without power: the current dies away."""
        self.torque -= self._current_step * self.torque
        return self.torque

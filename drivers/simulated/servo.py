"""The position loop of one drive, running at the plant's step rate.

Its feedback is the drive's fine internal angle, not the reported counts: real drives interpolate the signals of their
encoders, so that the gains do not amplify quantisation noise.
"""

from collections import deque

from drivers.simulated.config import Servo


class PositionLoop:
    """Position P, velocity PI with feed-forward, current limit and current loop of one joint."""

    def __init__(self, servo: Servo, dt: float, smoothing: int) -> None:
        """`smoothing`: number of steps of the moving average of the setpoints; one SYNC period, so that linear
        interpolation between the targets of two SYNCs gives a continuous velocity."""
        self._position_gain = servo.position_gain
        self._velocity_gain = servo.velocity_gain
        self._integral_gain = servo.velocity_gain / servo.integral_time * dt
        self._limit = servo.torque_limit
        self._current_step = min(dt / servo.current_lag, 1.0)
        self._smoothing, self._window = smoothing, smoothing * dt
        self._setpoints: deque[float] = deque([0.0] * smoothing, maxlen=smoothing)
        # Steps from the middle of the window to the present: the setpoint is that of the end of the step.
        self._exact, self._velocity_lead = servo.exact_reference, 0.5 - 1 / smoothing
        self._position_lead = (0.5 - 1.5 / smoothing if servo.exact_reference else 0.5) * self._window
        self._velocities: deque[float] = deque([0.0] * smoothing, maxlen=smoothing)
        self._sum = 0.0
        self._integral = 0.0
        self.torque = 0.0
        """Torque of the current [N m]."""

    def restart(self, position: float) -> None:
        """Clear the memory of the loop and hold `position` [rad]."""
        self._setpoints.extend([position] * self._smoothing)
        self._velocities.extend([0.0] * self._smoothing)
        self._sum = position * self._smoothing
        self._integral = 0.0

    def follow(self, setpoint: float, q: float, v: float, torque_offset: float = 0.0) -> float:
        """One step of the closed loop: torque [N m] at the motor's angle q [rad] and speed v [rad/s].

        `torque_offset` [N m] is added to the demand of the velocity controller, before the current limit.
        """
        setpoints = self._setpoints
        oldest = setpoints[0]
        setpoints.append(setpoint)
        self._sum += setpoint - oldest
        # The derivative of a moving average is the difference over its window; the present lies half a window ahead
        # of the average.
        v_reference = (setpoint - oldest) / self._window
        reference = self._sum / self._smoothing + self._position_lead * v_reference
        if self._exact:
            before = self._velocities[0]
            self._velocities.append(v_reference)
            v_reference += self._velocity_lead * (v_reference - before)
        v_error = v_reference + self._position_gain * (reference - q) - v
        demand = self._velocity_gain * v_error + self._integral + torque_offset
        limit = self._limit
        # Comparisons are much faster than min and max.
        limited = limit if demand > limit else -limit if demand < -limit else demand
        if demand == limited:
            self._integral += self._integral_gain * v_error
        self.torque += self._current_step * (limited - self.torque)
        return self.torque

    def idle(self) -> float:
        """One step without power: the current decays."""
        self.torque -= self._current_step * self.torque
        return self.torque

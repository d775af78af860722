"""Setpoints of a drive's position loop: interpolation between targets, and the quick stop ramp."""


class SetpointGenerator:
    """Joint angle setpoints of one axis, one per plant step."""

    def __init__(self, dt: float) -> None:
        """`dt`: plant step [s]."""
        self._dt = dt
        self.position = 0.0
        """Present setpoint [rad]."""
        self._velocity = 0.0
        self._deceleration: float | None = None
        self._steps_left = 0

    def hold(self, position: float) -> None:
        """Hold `position` [rad]."""
        self.position = position
        self._velocity = 0.0
        self._deceleration = None
        self._steps_left = 0

    def interpolate(self, target: float, period: float) -> None:
        """Move linearly to `target` [rad] within `period` [s], then hold it."""
        self._steps_left = max(1, round(period / self._dt))
        self._velocity = (target - self.position) / (self._steps_left * self._dt)
        self._deceleration = None

    def stop(self, deceleration: float) -> None:
        """Decelerate to rest with `deceleration` [rad/s^2] from the present speed."""
        self._deceleration = deceleration

    @property
    def at_rest(self) -> bool:
        """True when the motion has ended."""
        return self._velocity == 0.0

    def step(self) -> float:
        """The setpoint one plant step later [rad]."""
        if self._deceleration is not None:
            change = self._deceleration * self._dt
            self._velocity = max(0.0, abs(self._velocity) - change) * (1.0 if self._velocity > 0 else -1.0)
        elif self._steps_left == 0:
            self._velocity = 0.0
        else:
            self._steps_left -= 1
        self.position += self._velocity * self._dt
        return self.position

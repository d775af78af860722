"""Motion control of a simulated CiA 402 drive: power states, operation modes, stops, following error, units."""

from collections.abc import Callable, Iterator
from itertools import cycle

from drivers.simulated.drive_state_machine import PowerState, next_state
from drivers.simulated.drive_units import FactorGroup
from drivers.simulated.habits import Habits
from drivers.simulated.objects import Objects
from drivers.simulated.setpoint_generator import SetpointGenerator
from recordings.rig import Drive

_VOLTAGE_ENABLED, _REMOTE, _TARGET_REACHED, _FOLLOWS, _DEVIATES = 0x10, 0x200, 0x400, 0x1000, 0x2000
_LIMITED = 0x800
_HOMING, _INTERPOLATED, _CYCLIC = 6, 7, 8
_TARGETS = {_INTERPOLATED: (0x60C1, 1), _CYCLIC: (0x607A, 0)}
_NEW_SETPOINT = 0x10
"""Controlword bit 4: interpolate in mode 7, start homing in mode 6."""
_HERE = (35, 37)
"""Homing methods that take the present position as zero."""
_UNLIMITED = 2**32 - 1
_SLOW_RAMP, _QUICK_STOP_RAMP, _LAST_RAMP = 1, 2, 4
"""Option codes of 605Ah and 605Eh; 5 to 8 are 1 to 4, after which the drive stays in Quick stop active."""
_FILTER = 0.2
"""Share of the velocity between two SYNCs in the low-passed one."""
_STRONGEST = 400.0
"""Deceleration at the current limit, and where the dictionary has no ramp or none was set [rad/s^2]."""
FOLLOWING_ERROR = 0x8611


class MotionControl:
    """State of one axis. `powered` and `generator` command the machine; positions are encoder increments."""

    def __init__(
        self, objects: Objects, drive: Drive, habits: Habits, dt: float, on_reset: Callable[[], None]
    ) -> None:
        """`drive` has the machine's encoder and gear; `dt`: plant step [s]; `on_reset`: called after a reset."""
        self._objects, self._drive, self._habits = objects, drive, habits
        self._on_reset = on_reset
        self.state = PowerState.SWITCH_ON_DISABLED
        self._flickering: Iterator[int] | None = None
        self.generator = SetpointGenerator(dt)
        self.restart(0.0)

    def restart(self, now: float) -> None:
        """Begin anew, without power."""
        self.units = FactorGroup(self._objects, self._drive, in_increments=self._habits.position_in_increments)
        self.now = now
        self.counts = 0
        self.reset_blocked = False
        """Whether a fault reset has no effect."""
        self._referenced = self._habits.referenced
        self._is_homing = self._homing_started = self._homing_failed = False
        self._previous_controlword = 0
        self._following_error_since: float | None = None
        self._pause = 0.0
        self._reset_due: float | None = None
        self._enable_due: float | None = None
        self._at_limit, self._flickering = False, None
        self._after_stop = PowerState.SWITCH_ON_DISABLED
        self._last_sync: float | None = None
        self._counts_at_sync, self._speed = 0, 0.0
        self._sync_period = 0.0
        self.disable()

    def lose_turns(self, turns: int) -> int:
        """Let the encoder be wrong by turns of the motor, without power; returns that in increments."""
        increments = turns * self._drive.counts_per_turn
        shift = increments / self._drive.counts_per_radian
        self._drive = self._drive.model_copy(update={"zero_offset": self._drive.zero_offset - shift})
        return increments

    @property
    def powered(self) -> bool:
        """True while the position loop is closed."""
        return self.state in (PowerState.ENABLED, PowerState.QUICK_STOP, PowerState.FAULT_REACTION)

    @property
    def failed(self) -> bool:
        """Whether there is a fault."""
        return self.state in (PowerState.FAULT, PowerState.FAULT_REACTION)

    @property
    def mode(self) -> int:
        """Mode of operation."""
        return self._objects.value(0x6060)

    @property
    def statusword(self) -> int:
        """Object 6041."""
        word = self.state.value | _REMOTE
        if self.state is not PowerState.SWITCH_ON_DISABLED:
            word |= _VOLTAGE_ENABLED
        if self._flickering is not None and self.state is PowerState.ENABLED and not next(self._flickering):
            return PowerState.SWITCHED_ON.value | _REMOTE | _VOLTAGE_ENABLED
        if self.state is PowerState.ENABLED and self._follows:
            word |= _FOLLOWS
        if self._at_limit:
            word |= _LIMITED
        if self._following_error_since is not None:
            word |= _DEVIATES
        if self._referenced:
            word |= self._habits.referenced_mask
        if self.mode == _HOMING and self.state is PowerState.ENABLED:
            word |= self._homing_bits
        return word

    @property
    def _homing_bits(self) -> int:
        if self._homing_failed:
            return _DEVIATES
        return 0 if self._is_homing else _TARGET_REACHED | (_FOLLOWS if self._referenced else 0)

    # Controlword

    def apply_controlword(self, controlword: int) -> None:
        """Follow the transition that a controlword commands."""
        state = next_state(self.state, controlword, self._previous_controlword)
        self._previous_controlword = controlword
        if state is not PowerState.ENABLED:
            self._enable_due = None
        if state is self.state:
            if state is PowerState.ENABLED and self.mode == _HOMING and controlword & _NEW_SETPOINT:
                self._begin_homing()
        elif state is PowerState.ENABLED:
            self._enable()
        elif state is PowerState.QUICK_STOP:
            self.quick_stop()
        elif self.state is PowerState.FAULT:
            self._begin_reset()
        elif self.powered:
            self.disable(state)
        else:
            self.state = state

    def _begin_homing(self) -> None:
        """Search the home switch; once for each start. Without a speed there is a homing error."""
        if self._is_homing or self._homing_started:
            return
        self._homing_started = True
        if self._objects.value(0x6098, absent=_HERE[0]) in _HERE:
            self._referenced = True
            return
        speed = self._objects.value(0x6099, 1) / self.units.velocity
        self._homing_failed = speed <= 0
        if not self._homing_failed:
            self._referenced, self._is_homing = False, True
            distance = self._habits.home_distance
            self.generator.interpolate(self.generator.position + distance, distance / speed)

    def _end_homing(self) -> None:
        if self._is_homing and self.generator.at_rest:
            self._is_homing, self._referenced = False, True

    def _enable(self) -> None:
        if self._enable_due is None:
            self._enable_due = self.now + self._habits.enabling
        if self.now >= self._enable_due:
            # A target received before power-on must not move the axis.
            self.generator.hold(self._drive.to_position(self.counts))
            self.state = PowerState.ENABLED

    def disable(self, state: PowerState = PowerState.SWITCH_ON_DISABLED) -> None:
        """Switch power off; the axis ends in `state`."""
        self.state = state
        self._is_homing = self._homing_started = self._homing_failed = False
        self.generator.hold(self.generator.position)

    def _begin_reset(self) -> None:
        if not self.reset_blocked and self._reset_due is None:
            self._reset_due = self.now + self._pause + self._habits.fault_reset
            self._end_reset()

    def _end_reset(self) -> None:
        if self._reset_due is not None and self.now + self._pause >= self._reset_due:
            self._reset_due = None
            self.disable()
            self._on_reset()

    # Targets

    def synchronise(self, now: float) -> None:
        """Note the time of a SYNC and, from the increments since the last one, the speed."""
        if self._last_sync is not None:
            self._sync_period = now - self._last_sync
        if self._sync_period > 0:
            speed = (self.counts - self._counts_at_sync) / self._sync_period
            self._speed += _FILTER * (speed - self._speed)
        self._last_sync, self._counts_at_sync = now, self.counts
        self.now = now

    def follow_target(self) -> None:
        """Move to the target of the mode of operation, if the drive is enabled and has such a mode."""
        if self.state is PowerState.ENABLED and self._follows:
            # Some dictionaries call it unsigned.
            raw = self._objects.value(*_TARGETS[self.mode])
            target = self._limited(raw - (1 << 32) if raw >= 1 << 31 else raw)
            position = self._drive.to_position(round(target / self.units.position))
            self.generator.interpolate(position, self._interpolation_time())

    def _limited(self, target: int) -> int:
        low, high = self._objects.value(0x607D, 1), self._objects.value(0x607D, 2)
        return min(max(target, low), high) if low < high else target

    def _interpolation_time(self) -> float:
        """Time until the next target [s]: 60C2h, or without it the time between the last two SYNCs."""
        time = self._objects.value(0x60C2, 1) * 10.0 ** self._objects.value(0x60C2, 2, absent=-3)
        return time or self._sync_period

    @property
    def torque_offset(self) -> int:
        """Object 60B2h in cyclic mode while the loops are closed, also on the ramp of a stop; otherwise 0."""
        return self._objects.value(0x60B2) if self.powered and self.mode == _CYCLIC else 0

    @property
    def _follows(self) -> bool:
        """Whether the target is followed: in interpolated position mode the controlword must enable it."""
        if self._at_limit:
            return False
        if self.mode == _INTERPOLATED:
            return bool(self._objects.value(0x6040) & _NEW_SETPOINT)
        return self.mode == _CYCLIC

    # Stops

    def quick_stop(self) -> None:
        """Stop as object 605Ah says; without it, on the quick stop ramp."""
        self._stop(PowerState.QUICK_STOP, self._objects.value(0x605A, absent=_QUICK_STOP_RAMP))

    def reach_limit(self) -> None:
        """Stop at a limit switch on the quick stop ramp, and follow no target any more."""
        self._at_limit = True
        self.generator.stop(self._deceleration(_QUICK_STOP_RAMP))

    def flicker(self) -> None:
        """Let every tenth statusword say another state from now on."""
        self._flickering = cycle(range(9, -1, -1))

    def enter_fault(self) -> None:
        """Stop as object 605Eh says, without it on the quick stop ramp, then Fault."""
        if self.powered:
            self._stop(PowerState.FAULT_REACTION, self._objects.value(0x605E, absent=_QUICK_STOP_RAMP))
        else:
            self.disable(PowerState.FAULT)

    def _stop(self, during: PowerState, option: int) -> None:
        afterwards = PowerState.FAULT if during is PowerState.FAULT_REACTION else PowerState.SWITCH_ON_DISABLED
        if option <= 0:
            self.disable(afterwards)
            return
        if option > _LAST_RAMP and during is PowerState.QUICK_STOP:
            afterwards = PowerState.QUICK_STOP
        self.state, self._after_stop = during, afterwards
        self.generator.stop(self._deceleration((option - 1) % _LAST_RAMP + 1))

    def _deceleration(self, option: int) -> float:
        """Deceleration of a ramp [rad/s^2]."""
        index = {_SLOW_RAMP: 0x6084, _QUICK_STOP_RAMP: 0x6085}.get(option, 0)
        return self._objects.value(index) / self.units.acceleration or _STRONGEST

    # Simulated time

    def pass_time(self, duration: float) -> None:
        """Let time pass in which the machine does not move [s]: in lockstep, that of SDO transfers."""
        self._pause += duration
        self._end_reset()

    def update(self, counts: int, now: float) -> bool:
        """Update encoder and clock [s] after the machine has moved; True if the following error is too large."""
        self.counts, self.now = counts, now
        stopping = self.state in (PowerState.QUICK_STOP, PowerState.FAULT_REACTION)
        if stopping and self.generator.at_rest and self._after_stop is not PowerState.QUICK_STOP:
            self.disable(self._after_stop)
        self._end_reset()
        self._end_homing()
        return self._deviates(now)

    @property
    def velocity(self) -> float:
        """Velocity, low-passed, in velocity units of the drive."""
        return self._speed * self.units.velocity / abs(self._drive.counts_per_radian)

    @property
    def following_error(self) -> float:
        """Setpoint minus position, in position units of the drive."""
        increments = (self.generator.position - self._drive.to_position(self.counts)) * self._drive.counts_per_radian
        return increments * self.units.position

    def _deviates(self, now: float) -> bool:
        window = self._objects.value(0x6065)
        if not self.powered or window in (0, _UNLIMITED) or abs(self.following_error) <= window:
            self._following_error_since = None
            return False
        if self._following_error_since is None:
            self._following_error_since = now
        return (now - self._following_error_since) * 1000 >= self._objects.value(0x6066)

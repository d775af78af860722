"""Watchdogs of a simulated drive on its master: consumer heartbeat (1016h) and life guarding (100Ch, 100Dh)."""

from drivers.simulated.objects import Objects

_CONSUMER, _GUARD_TIME, _LIFE_TIME_FACTOR = 0x1016, 0x100C, 0x100D
_NODE_IDS = range(1, 128)


class MasterWatch:
    """Supervision of the master; each watchdog is armed by the first sign of life after it was set up."""

    def __init__(self, objects: Objects) -> None:
        self._objects = objects
        self._consumers = [sub for sub in _NODE_IDS if (_CONSUMER, sub) in objects]
        self.restart()

    def restart(self) -> None:
        """Disarm the watchdogs."""
        self._heard: dict[int, float] = {}
        self._guarded: float | None = None
        self._toggle = 0

    def hear(self, node: int, now: float) -> None:
        """Take a heartbeat of `node`."""
        self._heard[node] = now

    def guard(self, now: float) -> int:
        """Take a guarding request; returns the toggle bit of the answer."""
        self._guarded = now
        toggle, self._toggle = self._toggle, self._toggle ^ 0x80
        return toggle

    def set_up(self, index: int) -> None:
        """Disarm the watchdog whose object was written."""
        if index == _CONSUMER:
            self._heard.clear()
        elif index in (_GUARD_TIME, _LIFE_TIME_FACTOR):
            self._guarded = None

    def is_lost(self, now: float) -> bool:
        """Whether the master has been silent for too long; said once, then the watchdog waits to be armed again."""
        return self._heartbeat_lost(now) or self._guarding_lost(now)

    def _heartbeat_lost(self, now: float) -> bool:
        for sub in self._consumers:
            entry = self._objects.value(_CONSUMER, sub)
            node, timeout = entry >> 16 & 0x7F, (entry & 0xFFFF) / 1000
            if timeout and node in self._heard and now - self._heard[node] > timeout:
                del self._heard[node]
                return True
        return False

    def _guarding_lost(self, now: float) -> bool:
        life_time = self._objects.value(_GUARD_TIME) * self._objects.value(_LIFE_TIME_FACTOR) / 1000
        if not life_time or self._guarded is None or now - self._guarded <= life_time:
            return False
        self._guarded = None
        return True

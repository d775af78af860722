"""Whether one node alone has its id: its answers, its heartbeats or answers to guarding, and its boot-up messages.

Frames are read in the order of the bus, on a late host too: what is read after a message was sent after it. What
comes is compared with what was asked for, not with the cycle in which it comes.
"""

import math
from collections import Counter

from drivers.canopen import requirements

NO_PDOS = {0x04: "stopped", 0x7F: "pre-operational"}
"""States of communication in which a node sends no PDO, by its heartbeat."""
_BOOT_UP, _OPERATIONAL = 0x00, 0x05
_FORGIVING = 50
"""Complete cycles in a row after which a node is known to answer each SYNC, and a host to read in time."""
_STALL = 0.1
"""Pause of the host after which heartbeats come in a heap [s]."""
_MOST_HEARTBEATS, _HEAP = 4 / 3, 5.0
"""Heartbeats in their interval that one node sends at most, and those that may come in a heap: a second node that
sends as often is found after 8 intervals, and a delay of 4 intervals is none."""
_REPEATED = 1.0
"""Interval in which CAN may repeat a request of guarding or its answer: a frame whose end was disturbed [s]."""


class Presence:
    """What is heard of one node, and whether a second one has its id."""

    def __init__(self, node_id: int) -> None:
        self._cob_id = 0x700 + node_id
        """Of heartbeats, answers to guarding and boot-up messages."""
        self.interval = requirements.DRIVE_HEARTBEAT_MS / 1000
        """Time between two heartbeats [s]."""
        self.guarded = False
        """Whether the node answers guarding, instead of a heartbeat."""
        self.nmt_state = 0
        """State of communication by a heartbeat since the last answer; 0: there was none."""
        self.last_heard: int | None = None
        """Cycle of the last heartbeat or answer to guarding; None: there was none."""
        self.trouble = ""
        """Restart, or what shows that a second node has this id; "": nothing does."""
        self._suspicion: tuple[int, str, str] | None = None
        """Cycle of a frame that our node sends only if it stops answering, that frame, and the trouble if it does."""
        self._owed = Counter[int]()
        """Answers of each COB-ID that were asked for and have not come. On a busy host, all may be late for long."""
        self._last: dict[int, bytes] = {}
        self._complete = 0
        """Number of complete cycles in a row."""
        self._answers = self._settled = self._was_operational = False
        """Whether a SYNC was answered, many in a row were, and a heartbeat has said "operational"."""
        self._began, self._heard_at, self._credit = -math.inf, -math.inf, _HEAP

    def ask(self, *cob_ids: int) -> None:
        """Note that an answer of each COB-ID is asked for."""
        self._owed.update(cob_ids)

    def guard(self, cycle: int) -> None:
        """Note a request of guarding, sent in `cycle`."""
        self.last_heard = self.last_heard or cycle
        self.ask(self._cob_id)

    def begin_cycle(self, now: float, answered: bool) -> None:
        """Begin a cycle at `now` [s]; `answered`: whether the one before was complete."""
        self._complete = self._complete + 1 if answered and now - self._began < _STALL else 0
        self._settled |= self._complete == _FORGIVING
        self._began = now

    def take_answer(self, cob_id: int, data: bytes) -> None:
        """Note the answer that is used in this cycle."""
        self._pay(cob_id)
        self._last[cob_id], self.nmt_state, self._answers = data, 0, True

    def is_foreign(self, cob_id: int, data: bytes) -> bool:
        """Whether a further answer is of another node: it is neither late, nor the last one again, as CAN repeats a
        frame whose end was disturbed."""
        before, self._last[cob_id] = self._last.get(cob_id), data
        return not self._pay(cob_id) and self._settled and data != before

    def _pay(self, cob_id: int) -> bool:
        """Count an answer; whether it was owed."""
        owed = self._owed[cob_id]
        self._owed[cob_id] = max(owed - 1, 0)
        return owed > 0

    def hear(self, data: bytes, cycle: int, now: float) -> None:
        """Note a heartbeat, an answer to guarding or a boot-up message, which is not empty, at `now` [s]."""
        if data[0] == _BOOT_UP:
            # Before the first answer, it may be of a reset in the preparation.
            if self._answers:
                self._suspicion = cycle, "a boot-up message", "the drive restarted (boot-up message)"
            return
        state = data[0] & 0x7F
        if not (self.guarded and self._pay(self._cob_id)) and self._are_too_many(now):
            self.trouble = self.trouble or self._second(
                "heartbeats beside the answers to node guarding" if self.guarded else "twice as many heartbeats"
            )
        if self._complete >= _FORGIVING and self._was_operational and state in NO_PDOS:
            self._suspicion = cycle, f"a heartbeat that says {NO_PDOS[state]}", ""
        self._was_operational |= state == _OPERATIONAL
        self.last_heard = cycle
        # Before the first answer, a heartbeat may be older than the command to start.
        self.nmt_state = state if self._answers else 0

    def _are_too_many(self, now: float) -> bool:
        interval = _REPEATED if self.guarded else self.interval / _MOST_HEARTBEATS
        credit = min(_HEAP, self._credit + max(0.0, now - self._heard_at) / interval)
        # Without regular cycles, heartbeats wait for each other and for the first command.
        self._heard_at, self._credit = now, credit - 1 if self._complete >= _FORGIVING else _HEAP
        return self._credit < 0

    def end_cycle(self, cycle: int, answered: bool) -> None:
        """Judge by the answers of `cycle` who has sent what our node sends only when it stops answering."""
        if self._suspicion is not None and cycle > self._suspicion[0]:
            (_, seen, otherwise), self._suspicion = self._suspicion, None
            self.trouble = self.trouble or (self._second(seen) if answered else otherwise)

    def _second(self, seen: str) -> str:
        return f"a second node has its id: {seen} (COB-ID {self._cob_id:03X}h), and the drive goes on; change one id"

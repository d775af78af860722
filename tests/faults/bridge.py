"""Cable with a saboteur: forwards CAN frames between the buses of the recorder and of the rig."""

import threading
from collections.abc import Callable, Iterable

import can

Saboteur = Callable[[can.Message, bool, int], Iterable[can.Message]]
"""Function of a frame, whether the master sent it, and the number of SYNCs so far; returns the forwarded frames."""


def unchanged(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    """Forward every frame unchanged."""
    return (message,)


class Bridge:
    """Context manager that forwards frames in two threads, one per direction."""

    def __init__(self, master: str, rig: str, saboteur: Saboteur) -> None:
        """Connect the channels `master` and `rig` of python-can's virtual bus."""
        self._ends = [can.Bus(interface="virtual", channel=channel) for channel in (master, rig)]
        self._saboteur = saboteur
        self._stopped = threading.Event()
        self._threads = [
            threading.Thread(target=self._forward, args=(source, target, source is self._ends[0]), daemon=True)
            for source, target in (self._ends, self._ends[::-1])
        ]
        self.syncs = 0
        """Number of SYNCs that the master has sent."""
        self.enabled_until = 0
        """Number of SYNCs that the master had sent when it last let a drive follow its target."""
        self.delivered_syncs = 0
        """Number of SYNCs that have been forwarded to the rig."""
        self.answers = 0
        """Number of frames of the rig that have been forwarded or dropped."""

    def _forward(self, source: can.BusABC, target: can.BusABC, from_master: bool) -> None:
        while not self._stopped.is_set():
            message = source.recv(0.05)
            if message is None:
                continue
            if from_master and message.arbitration_id == 0x80:
                self.syncs += 1
            if from_master and message.arbitration_id & 0x780 == 0x200 and message.data[0] & 0xF == 0xF:
                self.enabled_until = self.syncs
            for forwarded in self._saboteur(message, from_master, self.syncs):
                self.delivered_syncs += from_master and forwarded.arbitration_id == 0x80
                target.send(forwarded)
            self.answers += not from_master

    def __enter__(self) -> "Bridge":
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        for thread in self._threads:
            thread.join()
        for end in self._ends:
            end.shutdown()

"""Frames that only the master of this bus may send, heard from another: what each means, and whether it ends the run.

A frame that this program sent itself does not come back: `Link` takes echoes out.
"""

from collections.abc import Callable, Sequence
from functools import partial

from drivers.canopen import setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.sdo import format_address
from drivers.protocol import Report

_NMT = {0x01: "start", 0x02: "stop", 0x80: "enter pre-operational", 0x81: "reset", 0x82: "reset communication"}
_START = 0x01
_DOWNLOADS = (0, 1, 6)
"""Client command specifiers of SDO (the upper three bits) that write: a segment, the beginning, a block."""

Handler = Callable[[bytes], None]


class BusMonitor:
    """Finder of another master's frames. `armed`: from now on those that endanger the run end it."""

    def __init__(self, axes: Sequence[CanopenAxis], report: Report, *, sends_sync: bool) -> None:
        """`sends_sync`: this program sends SYNC frame by frame; those of the kernel are heard like foreign ones."""
        self._axes = axes
        self._report = report
        self._sends_sync = sends_sync
        self._told: set[str] = set()
        self.armed = False
        self.trouble: str | None = None
        """The first frame that ended the run; None: there was none."""

    def handlers(self) -> dict[int, Handler]:
        """Handlers of these frames by their COB-ID."""
        heartbeat = 0x700 + setup.MASTER_ID
        found: dict[int, Handler] = {0x000: self._on_nmt}
        found[heartbeat] = partial(self._on_any, heartbeat, "a master's heartbeat", False)
        if self._sends_sync:
            found[setup.SYNC_ID] = partial(self._on_any, setup.SYNC_ID, "a second SYNC", True)
        for axis in self._axes:
            for cob_id in axis.command_ids:
                found[cob_id] = partial(self._on_any, cob_id, f"an RPDO that commands {axis.name}", True)
            found[0x600 + axis.drive.node_id] = partial(self._on_sdo, axis)
        return found

    def _on_any(self, cob_id: int, what: str, ends_run: bool, data: bytes) -> None:
        self._tell(cob_id, what, ends_run)

    def _on_nmt(self, data: bytes) -> None:
        command, node = (*data, 0, 0)[:2]
        names = {axis.drive.node_id: axis.name for axis in self._axes}
        if node and node not in names:
            return
        target = names[node] if node else "all nodes"
        self._tell(0x000, f'NMT "{_NMT.get(command, command)}" to {target}', command != _START)

    def _on_sdo(self, axis: CanopenAxis, data: bytes) -> None:
        writes = bool(data) and data[0] >> 5 in _DOWNLOADS
        address = f" {format_address(data[1] | data[2] << 8, data[3])}" if len(data) >= 4 and data[0] >> 5 else ""
        what = f"an SDO {'write to' if writes else 'request to'} {axis.name}{address}"
        self._tell(0x600 + axis.drive.node_id, what, writes)

    def _tell(self, cob_id: int, what: str, ends_run: bool) -> None:
        """Report each kind of frame at its first coming."""
        text = f"{what}, sent by another master (COB-ID {cob_id:03X}h); disconnect it"
        ends_run = ends_run and self.armed
        if ends_run and self.trouble is None:
            self.trouble = text
        if text not in self._told:
            self._told.add(text)
            self._report("error" if ends_run else "warning", "bus", text)

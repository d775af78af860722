"""What others send on this bus, what is wrong with what our drives send, and errors of the bus; what ends the run.

A frame that this program sent itself does not come back: `Link` takes echoes out.
"""

from collections.abc import Callable, Sequence
from functools import partial

import can

from drivers.canopen import can_errors, requirements
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.discovery import axes_by_node, names
from drivers.canopen.sdo import format_address
from drivers.protocol import Report
from recordings.rig import Rig
from recordings.schemas import Level

_NMT = {0x01: "start", 0x02: "stop", 0x80: "enter pre-operational", 0x81: "reset", 0x82: "reset communication"}
_START = 0x01
_DOWNLOADS = (0, 1, 6)
"""Client command specifiers of SDO (the upper three bits) that write: a segment, the beginning, a block."""
_LOAD_TIME = 0.05
"""Time over which the load is measured [s]."""
_OVERLOAD = 0.9
"""Share of the bit rate above which a bus, in the worst case of stuffed bits, has no room left."""

Handler = Callable[[bytes], None]


class BusMonitor:
    """Finder of another master's frames. `armed`: from now on those that endanger the run end it."""

    def __init__(self, axes: Sequence[CanopenAxis], link: Link, rig: Rig, report: Report) -> None:
        self._axes = axes
        self._link = link
        self._rig = rig
        self._load_window = max(1, round(_LOAD_TIME * rig.rate))
        self._bits: int | None = None
        """Bits on the bus before this window; None: before the first one, there was the set-up."""
        self._report = report
        self._told: set[str] = set()
        self.armed = False
        self.trouble: str | None = None
        """Bus-off, or else the first frame that ended the run; None: there was none."""
        link.on_error_frame = self._on_error_frame

    def handlers(self) -> dict[int, Handler]:
        """Handlers of these frames by their COB-ID."""
        heartbeat = 0x700 + requirements.MASTER_ID
        found: dict[int, Handler] = {0x000: self._on_nmt}
        found[heartbeat] = partial(self._on_any, heartbeat, "a master's heartbeat", False)
        # The kernel's SYNC is heard like any; which is whose `KernelSync` knows.
        if self._rig.can.sync == "host":
            found[requirements.SYNC_ID] = lambda data: self.second_sync()
        for axis in self._axes:
            for cob_id in axis.rpdos:
                found[cob_id] = partial(self._on_any, cob_id, f"an RPDO that commands {axis.name}", True)
            for cob_id in axis.tpdos:
                found[cob_id] = partial(self._on_tpdo, axis, cob_id)
        for node_id, axes in axes_by_node(self._axes).items():
            found[0x600 + node_id] = partial(self._on_sdo, node_id, names(axes))
        return found

    def second_sync(self) -> None:
        """Note a SYNC that is not ours."""
        self._tell(requirements.SYNC_ID, "a second SYNC", True)

    def end_cycle(self, cycle: int) -> None:
        """Judge what needs the answers of the cycle: doubled nodes, wrong lengths, the load."""
        for axis in self._axes:
            if (seen := axis.second_node(cycle)) is not None:
                cob_id = 0x700 + axis.drive.node_id
                self._warn(
                    f"node id {axis.drive.node_id} is there twice: {seen} (COB-ID {cob_id:03X}h), and {axis.name} "
                    "goes on; give each drive its own node id"
                )
            if axis.is_limited:
                self._warn(
                    f"{axis.name}: internal limit active (statusword bit 11): a limit of the drive holds it back"
                )
            if axis.misfit:
                self._warn(f"{axis.name}: {axis.misfit}")
        if cycle % self._load_window == 0:
            before, self._bits = self._bits, self._link.bits
            bits = 0 if before is None else self._bits - before
            load = bits * self._rig.rate / self._load_window / self._rig.can.bitrate
            if load > _OVERLOAD:
                figures = f" ({load:.0%} in {_LOAD_TIME} s)"
                self._warn("the bus is full: look for a node that sends without pause", figures)

    def _on_any(self, cob_id: int, what: str, ends_run: bool, data: bytes) -> None:
        self._tell(cob_id, what, ends_run)

    def _on_nmt(self, data: bytes) -> None:
        command, node = (*data, 0, 0)[:2]
        nodes = axes_by_node(self._axes)
        if node and node not in nodes:
            return
        target = names(nodes[node]) if node else "all nodes"
        self._tell(0x000, f'NMT "{_NMT.get(command, command)}" to {target}', command != _START)

    def _on_sdo(self, node_id: int, name: str, data: bytes) -> None:
        writes = bool(data) and data[0] >> 5 in _DOWNLOADS
        address = f" {format_address(data[1] | data[2] << 8, data[3])}" if len(data) >= 4 and data[0] >> 5 else ""
        what = f"an SDO {'write to' if writes else 'request to'} {name}{address}"
        self._tell(0x600 + node_id, what, writes)

    def _on_tpdo(self, axis: CanopenAxis, cob_id: int, data: bytes) -> None:
        if axis.is_foreign(cob_id, data):
            self._tell(cob_id, f"a second TPDO of {axis.name} in one cycle", True, "another node")

    def _tell(self, cob_id: int, what: str, ends_run: bool, sender: str = "another master") -> None:
        """Report a frame of another sender; the first one that endangers the run ends it."""
        text = f"{what}, sent by {sender} (COB-ID {cob_id:03X}h); disconnect it"
        ends_run = ends_run and self.armed
        if ends_run and self.trouble is None:
            self.trouble = text
        self._say("error" if ends_run else "warning", text)

    def _warn(self, text: str, figures: str = "") -> None:
        """Report what is wrong while the run goes on."""
        if self.armed:
            self._say("warning", text, figures)

    def _on_error_frame(self, message: can.Message) -> None:
        text = can_errors.decode(message.arbitration_id, bytes(message.data))
        if text == can_errors.BUS_OFF:
            self.trouble = text
        self._say("error" if text == can_errors.BUS_OFF else "warning", text)

    def _say(self, level: Level, text: str, figures: str = "") -> None:
        """Report each text once, with the figures of its first time."""
        if text not in self._told:
            self._told.add(text)
            self._report(level, "bus", text + figures)

"""What others send on this bus, what is wrong with what our drives send, and errors of the bus; what ends the run.

A frame that this program sent itself does not come back: `Link` takes echoes out.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial

import can

from drivers.canopen import can_errors, setup
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
_SENT_BY_DRIVES = {0x180: "TPDO 1", 0x280: "TPDO 2", 0x380: "TPDO 3", 0x480: "TPDO 4", 0x700: "the heartbeat"}
"""Frames that nodes send by themselves, by their function code in the predefined connection set."""
_LOAD_TIME = 0.05
"""Time over which the load is measured [s]; as often, the CAN controller is asked for its state."""
_OVERLOAD = 0.9
"""Share of the bit rate above which a bus, in the worst case of stuffed bits, has no room left."""

Handler = Callable[[bytes], None]


class BusMonitor:
    """Finder of frames of others. `armed`: from now on those that endanger the run end it."""

    def __init__(self, axes: Sequence[CanopenAxis], link: Link, rig: Rig, report: Report) -> None:
        self._axes = axes
        self._link = link
        self._rig = rig
        self._load_window = max(1, round(_LOAD_TIME * rig.rate))
        self._bits: int | None = None
        """Bits on the bus before this window; None: before the first one, there was the set-up."""
        self._first_bits, self._windows, self._peak = 0, 0, 0.0
        """Bits before the first window, number of windows, and the largest load in one."""
        self._report = report
        self._nodes = axes_by_node(axes)
        self._told: set[str] = set()
        self._frames = Counter[str]()
        """Number of frames that nobody expects, by what is said of them."""
        self.armed = False
        self.trouble: str | None = None
        """Bus-off, or else what others did first that ends the run; None: nothing."""
        link.on_error_frame = self._on_error_frame

    def handlers(self) -> dict[int, Handler]:
        """Handlers of these frames by their COB-ID."""
        heartbeat = 0x700 + setup.MASTER_ID
        found: dict[int, Handler] = {0x000: self._on_nmt}
        found[heartbeat] = partial(self._on_any, heartbeat, "a master's heartbeat", False)
        # The kernel's SYNC is heard like any; which is whose `KernelSync` knows.
        if self._rig.can.sync == "host":
            found[setup.SYNC_ID] = lambda data: self.take_sync(foreign=True)
        for axis in self._axes:
            for cob_id in axis.rpdos:
                found[cob_id] = partial(self._on_any, cob_id, f"an RPDO that commands {axis.name}", True)
            for cob_id in axis.tpdos:
                found[cob_id] = partial(self._on_tpdo, axis, cob_id)
        for node_id, axes in self._nodes.items():
            found[0x600 + node_id] = partial(self._on_sdo, node_id, names(axes))
        return found

    def take_sync(self, foreign: bool) -> None:
        """Note a SYNC, to which every drive owes an answer, whoever sent it."""
        for axis in self._axes:
            axis.presence.ask(*axis.tpdos)
        if foreign:
            self._tell(setup.SYNC_ID, "a second SYNC", True)

    def take_stray(self, cob_id: int) -> None:
        """Note a frame that nobody expects, where it is one that nodes send by themselves."""
        kind, node_id = cob_id & 0x780, cob_id & 0x7F
        if kind not in _SENT_BY_DRIVES or not node_id or not self.armed:
            return
        level: Level = "info" if kind == 0x700 else "warning"
        what, why = f"node {node_id}, which is not in the rig file", ""
        if node_id in self._nodes:
            what = f"{names(self._nodes[node_id])}, which this run does not use"
            why = "; a PDO that was not switched off, or a second node with this id"
        self._count(level, f"{_SENT_BY_DRIVES[kind]} of {what} (COB-ID {cob_id:03X}h){why}")

    def end_cycle(self, cycle: int) -> None:
        """Judge what needs the answers of the cycle: doubled nodes, wrong lengths, the load."""
        for axis in self._axes:
            presence, node_id = axis.presence, axis.drive.node_id
            presence.end_cycle(cycle, axis.answered)
            if presence.second:
                seen = f"{presence.second} (COB-ID {0x700 + node_id:03X}h)"
                self._end(
                    f"node id {node_id} is there twice: {seen}, and {names(self._nodes[node_id])} goes on; "
                    "give each drive its own node id"
                )
            if axis.is_limited:
                self._warn(
                    f"{axis.name}: internal limit active (statusword bit 11): a limit of the drive holds it back"
                )
            if axis.misfit:
                self._warn(f"{axis.name}: {axis.misfit}")
        if cycle % self._load_window == 0:
            self._measure_load()
            if state := self._link.controller:
                self._take_state(state)

    def _measure_load(self) -> None:
        before, self._bits = self._bits, self._link.bits
        if before is None:
            self._first_bits = self._bits
            return
        load = (self._bits - before) * self._rig.rate / self._load_window / self._rig.can.bitrate
        self._windows, self._peak = self._windows + 1, max(self._peak, load)
        if load > _OVERLOAD:
            figures = f" ({load:.0%} in {_LOAD_TIME} s)"
            self._warn("the bus is full: look for a node that sends without pause", figures)

    def report_totals(self) -> None:
        """Report how often came what was reported once, and the load of a bus on which others send."""
        for text, count in self._frames.items():
            if count > 1:
                self._report("info", "bus", f"{count} times: {text}")
        if self._frames and self._windows:
            bits = ((self._bits or 0) - self._first_bits) / self._windows
            mean = bits * self._rig.rate / self._load_window / self._rig.can.bitrate
            self._report("info", "bus", f"load {mean:.0%} on average, {self._peak:.0%} at most in {_LOAD_TIME} s")

    def _on_any(self, cob_id: int, what: str, ends_run: bool, data: bytes) -> None:
        self._tell(cob_id, what, ends_run)

    def _on_nmt(self, data: bytes) -> None:
        command, node = (*data, 0, 0)[:2]
        if node and node not in self._nodes:
            return
        target = names(self._nodes[node]) if node else "all nodes"
        self._tell(0x000, f'NMT "{_NMT.get(command, command)}" to {target}', command != _START)

    def _on_sdo(self, node_id: int, name: str, data: bytes) -> None:
        writes = bool(data) and data[0] >> 5 in _DOWNLOADS
        address = f" {format_address(data[1] | data[2] << 8, data[3])}" if len(data) >= 4 and data[0] >> 5 else ""
        what = f"an SDO {'write to' if writes else 'request to'} {name}{address}"
        self._tell(0x600 + node_id, what, writes)

    def _on_tpdo(self, axis: CanopenAxis, cob_id: int, data: bytes) -> None:
        if axis.presence.is_foreign(cob_id, data):
            self._tell(cob_id, f"a second TPDO of {axis.name} in one cycle", True, "another node")

    def _tell(self, cob_id: int, what: str, ends_run: bool, sender: str = "another master") -> None:
        """Report a frame of another sender; the first one that endangers the run ends it."""
        text = f"{what}, sent by {sender} (COB-ID {cob_id:03X}h); disconnect it"
        if ends_run:
            self._end(text)
        else:
            self._say("warning", text)

    def _end(self, text: str) -> None:
        """End the run, once it has begun, for the first reason of this kind."""
        if self.armed:
            self.trouble = self.trouble or text
        self._say("error" if self.armed else "warning", text)

    def _warn(self, text: str, figures: str = "") -> None:
        """Report what is wrong while the run goes on."""
        if self.armed:
            self._say("warning", text, figures)

    def _on_error_frame(self, message: can.Message) -> None:
        text = can_errors.decode(message.arbitration_id, bytes(message.data), self._rig.can.interface)
        if text in (can_errors.BUS_OFF, can_errors.ERROR_PASSIVE):
            self._take_state(text)
        else:
            self._count("warning", f"error frame: {text}")

    def _take_state(self, state: str) -> None:
        """Note that the CAN controller is error-passive, or in bus-off, which ends the run."""
        if state == can_errors.BUS_OFF:
            self.trouble = state
        self._say("error" if state == can_errors.BUS_OFF else "warning", state)

    def _count(self, level: Level, text: str) -> None:
        """Report a frame that nobody expects, and count it."""
        self._frames[text] += 1
        self._say(level, text)

    def _say(self, level: Level, text: str, figures: str = "") -> None:
        """Report each text once, with the figures of its first time."""
        if text not in self._told:
            self._told.add(text)
            self._report(level, "bus", text + figures)

"""What others send on this bus, what is wrong with what our drives send, and errors of the bus; what ends the run.

A frame that this program sent itself does not come back: `Link` takes echoes out.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial

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
        self._peak_load = 0.0
        self._report = report
        self._nodes = axes_by_node(axes)
        self._told = Counter[tuple[Level, str, str]]()
        """How often each text of each source was to be reported."""
        self.armed = False
        self.trouble: str | None = None
        """Bus-off, or else the first frame that ended the run; None: there was none."""
        link.on_error_frame = lambda frame: self._note_error(can_errors.decode(frame, rig.can.interface))

    def handlers(self) -> dict[int, Handler]:
        """Handlers of these frames by their COB-ID."""
        heartbeat = 0x700 + requirements.MASTER_ID
        found: dict[int, Handler] = {0x000: self._on_nmt}
        found[heartbeat] = partial(self._tell, heartbeat, "a master's heartbeat", False)
        # The kernel's SYNC is heard like any; which is whose `KernelSync` knows.
        if self._rig.can.sync == "host":
            found[requirements.SYNC_ID] = lambda data: self.take_sync(foreign=True)
        for axis in self._axes:
            for cob_id in axis.rpdos:
                found[cob_id] = partial(self._tell, cob_id, f"an RPDO that commands {axis.name}", True)
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
            self._tell(requirements.SYNC_ID, "a second SYNC", True)

    def take_stray(self, cob_id: int) -> None:
        """Note a frame that nobody expects, where it is one that nodes send by themselves."""
        kind, node_id = cob_id & 0x780, cob_id & 0x7F
        if self.armed and kind in _SENT_BY_DRIVES and node_id:
            whose = f"node {node_id}, which is not in the rig file"
            if node_id in self._nodes:
                whose = f"{names(self._nodes[node_id])}, not used in this run: not switched off, or of a second node"
            level: Level = "info" if kind == 0x700 else "warning"
            self.say(level, "bus", f"{_SENT_BY_DRIVES[kind]} of {whose} (COB-ID {cob_id:03X}h)")

    def end_cycle(self, cycle: int) -> None:
        """Judge what needs the answers of the cycle: doubled nodes, wrong lengths, the load."""
        for axis in self._axes:
            axis.presence.end_cycle(cycle, axis.answered)
            if axis.is_limited:
                self.say(
                    "warning",
                    "bus",
                    f"{axis.name}: internal limit active (statusword bit 11): a limit of the drive holds it back",
                )
            if axis.misfit:
                self.say("warning", "bus", f"{axis.name}: {axis.misfit}")
        if cycle % self._load_window == 0:
            before, self._bits = self._bits, self._link.bits
            bits = 0 if before is None else self._bits - before
            load = bits * self._rig.rate / self._load_window / self._rig.can.bitrate
            self._peak_load = max(self._peak_load, load)
            if load > _OVERLOAD:
                text = "the bus is full: look for a node that sends without pause"
                self.say("warning", "bus", text, f" ({load:.0%} in {_LOAD_TIME} s)")
            if state := self._link.controller():
                self._note_error(state)

    def say(self, level: Level, source: str, text: str, details: str = "") -> None:
        """Report each text once, with the details of its first time; count it."""
        self._told[level, source, text] += 1
        if self._told[level, source, text] == 1:
            self._report(level, source, text + details)

    def report_totals(self) -> None:
        """Report how often came what was reported once, and the load of the bus."""
        for (level, source, text), count in self._told.items():
            if count > 1 and level != "error":
                self._report("info", source, f"{count} times: {text}")
        if self._told:
            self._report("info", "bus", f"load of the bus at most {self._peak_load:.0%} in {_LOAD_TIME} s")

    def _on_nmt(self, data: bytes) -> None:
        command, node = (*data, 0, 0)[:2]
        if not node or node in self._nodes:
            target = names(self._nodes[node]) if node else "all nodes"
            self._tell(0x000, f'NMT "{_NMT.get(command, command)}" to {target}', command != _START)

    def _on_sdo(self, node_id: int, name: str, data: bytes) -> None:
        writes = bool(data) and data[0] >> 5 in _DOWNLOADS
        address = f" {format_address(data[1] | data[2] << 8, data[3])}" if len(data) >= 4 and data[0] >> 5 else ""
        what = f"an SDO {'write to' if writes else 'request to'} {name}{address}"
        self._tell(0x600 + node_id, what, writes)

    def _on_tpdo(self, axis: CanopenAxis, cob_id: int, data: bytes) -> None:
        if axis.presence.is_foreign(cob_id, data):
            self._tell(cob_id, f"a second TPDO of {axis.name} in one cycle", True, sender="another node")

    def _tell(
        self, cob_id: int, what: str, ends_run: bool, data: bytes = b"", sender: str = "another master"
    ) -> None:
        """Report a frame of another sender; the first one that endangers the run ends it."""
        text = f"{what}, sent by {sender} (COB-ID {cob_id:03X}h); disconnect it"
        ends_run = ends_run and self.armed
        if ends_run and self.trouble is None:
            self.trouble = text
        self.say("error" if ends_run else "warning", "bus", text)

    def _note_error(self, text: str) -> None:
        """Report an error of the bus; bus-off ends the run."""
        self.trouble = text if text == can_errors.BUS_OFF else self.trouble
        self.say("error" if text == can_errors.BUS_OFF else "warning", "bus", text)

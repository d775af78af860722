"""Faults of bus, drives and machine on CANopen."""

import itertools
import struct
from collections.abc import Callable, Iterable

import can
from can.interfaces.virtual import VirtualBus

from daq.cycle.session import Session
from drivers.protocol import Amplifiers
from tests.faults.bridge import Saboteur
from tests.faults.campaign import RATE, Fault, SabotagedRig
from tests.faults.saboteurs import (
    RPDO_2,
    START,
    SYNC,
    TPDO_2,
    accompany,
    alter,
    changed,
    delay,
    double,
    drop,
    on,
    reorder,
)

NO_ANSWER = r"joint 2: no answer for 50 ms"
SHORT = r"joint 2: no valid answer for 50 ms: its TPDO \(COB-ID 182h\) has %d bytes, 8 are mapped"
# A drive that holds still while the others move on strains its joint as it falls behind.
FOLLOWING = r"joint 2.*(following error|torque)"


def frame(arbitration_id: int, data: str) -> can.Message:
    """CAN frame that no node has sent."""
    return can.Message(arbitration_id=arbitration_id, data=bytes.fromhex(data), is_extended_id=False)


def error_frame(arbitration_id: int) -> can.Message:
    """An error frame as SocketCAN reports it."""
    return can.Message(arbitration_id=arbitration_id, data=bytes(8), is_error_frame=True)


def at(sync: int, act: Callable[[SabotagedRig], object]) -> Callable[[SabotagedRig, int], None]:
    """Apply `act` to the rig at one SYNC."""
    return lambda rig, count: act(rig) and None if count == sync else None


def happening(trouble: str) -> list[dict[str, object]]:
    """A trouble of the second drive in mid-motion, as the sim file says it."""
    return [{"at": START / RATE, "trouble": trouble, "joints": [2]}]


def always(act: Callable[[SabotagedRig], object]) -> Callable[[SabotagedRig, int], None]:
    """Apply `act` to the rig at every SYNC from START on."""
    return lambda rig, count: act(rig) and None if count >= START else None


def number(layout: str, begin: int, change: Callable[[int], int]) -> Callable[[bytes], bytes]:
    """Change one number in the data of a frame."""
    end = begin + struct.calcsize(layout)
    return lambda data: (
        data[:begin] + struct.pack(layout, change(*struct.unpack(layout, data[begin:end]))) + data[end:]
    )


# A position in a TPDO and a target in an RPDO stand at the same place, behind statusword and controlword.
_SHIFT = number("<i", 2, lambda counts: counts + (1 << 20))


def _two_of_three() -> Saboteur:
    number = itertools.count()
    return on(TPDO_2, lambda message: (message,) if next(number) % 3 else (), count=240)


def _silence_all(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    return () if syncs >= START else (message,)


def _refuse_sdo(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    if message.arbitration_id == 0x582 and message.data[0] == 0x60:
        return (changed(message, data=bytes([0x80]) + bytes(message.data[1:4]) + bytes.fromhex("22000008")),)
    return (message,)


def _swallow_sdo(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    return () if message.arbitration_id == 0x582 else (message,)


def _answer_twice(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    return (message, message) if message.arbitration_id == 0x582 else (message,)


def _block(rig: SabotagedRig) -> None:
    rig.machine.brake[1] = True
    rig.machine._config = rig.machine._config.model_copy(
        update={"servo": rig.machine._config.servo.model_copy(update={"brake_torque": 500.0})}
    )


def _freeze_encoder(rig: SabotagedRig) -> None:
    frozen = rig.machine.encoder_counts()
    rig.machine.encoder_counts = lambda: frozen  # type: ignore[method-assign]


def _shift_encoder(rig: SabotagedRig) -> None:
    true = rig.machine.encoder_counts

    def shifted() -> tuple[int, int, int]:
        first, second, third = true()
        return first, second + 3000, third

    rig.machine.encoder_counts = shifted  # type: ignore[method-assign]


def _stall(session: Session) -> None:
    clock = session._clock
    clock.overdue = lambda index: 0.2 if index == START else 0.0  # type: ignore[method-assign]


class SilentController(VirtualBus):
    """The recorder's end of a bus whose CAN controller goes into bus-off at START, and sends no error frame."""

    syncs = 0

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        self.syncs += msg.arbitration_id == SYNC
        super().send(msg, timeout)

    @property
    def state(self) -> can.BusState:
        return can.BusState.ERROR if self.syncs > START else can.BusState.ACTIVE


def _silent_bus_off(session: Session) -> None:
    connect = session._connect

    def connected() -> Amplifiers:
        drives = connect()
        drives._link._bus.__class__ = SilentController  # type: ignore[attr-defined]
        return drives

    session._connect = connected  # type: ignore[method-assign]


TOLERATED = "done"
BEAT = round(RATE / 10)
"""Cycles between two heartbeats."""


FAULTS: tuple[Fault, ...] = (
    Fault("none", TOLERATED, 0),
    Fault("one answer dropped", TOLERATED, 0, cable=lambda: drop(TPDO_2, 1)),
    Fault("answers dropped for 40 ms", TOLERATED, 0, cable=lambda: drop(TPDO_2, 10)),
    Fault("answers dropped here and there", "done; .* answers are missing", 0, cable=_two_of_three),
    Fault(
        "answers dropped here and there, then a jam",
        f"{FOLLOWING}.*; .* answers are missing",
        1,
        cable=_two_of_three,
        rig=at(START + 240, _block),
    ),
    Fault("all answers of a drive dropped", NO_ANSWER, 1, cable=lambda: drop(TPDO_2)),
    Fault("one setpoint dropped", TOLERATED, 0, cable=lambda: drop(RPDO_2, 1)),
    Fault("all setpoints of a drive dropped", FOLLOWING, 1, cable=lambda: drop(RPDO_2)),
    Fault("one SYNC dropped", TOLERATED, 0, cable=lambda: drop(SYNC, 1)),
    Fault(
        "all SYNCs dropped", "no answer for 50 ms|master heartbeat lost", 1, cable=lambda: drop(SYNC), pace="realtime"
    ),
    Fault("cable pulled", "no answer for 50 ms", 1, cable=lambda: _silence_all, pace="realtime"),
    Fault("one answer a cycle late", TOLERATED, 0, cable=lambda: delay(TPDO_2, 2)),
    # Answers have no counter, so this cannot be detected; the position error is the delay times the speed.
    Fault("all answers of a drive a cycle late", TOLERATED, 0, cable=lambda: delay(TPDO_2)),
    Fault("answers doubled", TOLERATED, 0, cable=lambda: double(TPDO_2)),
    Fault("setpoints doubled", TOLERATED, 0, cable=lambda: double(RPDO_2)),
    Fault("answers reordered", TOLERATED, 0, cable=lambda: reorder(0x181, 0x183)),
    Fault("setpoints after SYNC", TOLERATED, 0, cable=lambda: reorder(RPDO_2, SYNC)),
    Fault("answers truncated", SHORT % 5, 1, cable=lambda: alter(TPDO_2, lambda data: data[:5])),
    Fault("setpoints truncated", FOLLOWING, 1, cable=lambda: alter(RPDO_2, lambda data: data[:3])),
    Fault(
        "one position corrupted",
        "joint 2: position jump",
        1,
        cable=lambda: alter(TPDO_2, _SHIFT, 1),
    ),
    Fault(
        "one statusword corrupted",
        "joint 2.*fits no state",
        1,
        cable=lambda: alter(TPDO_2, number("<H", 0, lambda word: 3), 1),
    ),
    Fault("one target corrupted", TOLERATED, 0, cable=lambda: alter(RPDO_2, _SHIFT, 1)),
    Fault("targets corrupted", FOLLOWING, 1, cable=lambda: alter(RPDO_2, _SHIFT)),
    Fault(
        "voltage corrupted", "joint 2: torque", 1, cable=lambda: alter(TPDO_2, number("<h", 6, lambda counts: 0x7FFF))
    ),
    Fault(
        "answers under another node's id",
        NO_ANSWER,
        1,
        cable=lambda: on(TPDO_2, lambda message: (changed(message, arbitration_id=0x185),)),
    ),
    Fault("two drives with one node id", "two drives answer", 1, cable=lambda: _answer_twice),
    Fault(
        "babbling node",
        TOLERATED,
        0,
        cable=lambda: accompany(SYNC, lambda k: [frame(0x333, "0102030405060708")] * 20),
    ),
    Fault(
        "EMCY storm without fault",
        r"joint 2.*EMCY 0x4310: drive over-temperature",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x082, "1043000000000000")] * 5),
    ),
    Fault(
        "drive fault in mid-motion",
        r"joint 2.*over-current \(0x2310\)",
        1,
        rig=at(START, lambda r: r.drives[1].fail(0x2310)),
    ),
    Fault("drive fault on the approach", "over-temperature", 1, rig=at(60, lambda r: r.drives[0].fail(0x4310))),
    Fault("drive fault while enabling", "encoder error", 1, rig=at(3, lambda r: r.drives[2].fail(0x7305))),
    Fault("drive fault before power", "DC link under-voltage", 1, rig=at(0, lambda r: r.drives[0].fail(0x3220))),
    Fault("drive heartbeat lost", r"joint 2.*heartbeat lost", 1, cable=lambda: drop(0x702)),
    Fault("master heartbeat lost on the bus", "master heartbeat lost|left operation", 1, cable=lambda: drop(0x77F)),
    Fault(
        "drive restarts in mid-motion",
        r"joint 2.*restarted",
        1,
        rig=at(START, lambda r: r.drives[1].receive(0, bytes([0x81, 2]), r.machine.time)),
    ),
    Fault(
        "second node of our id boots",
        r"joint 2.*a second node has its id: a boot-up message \(COB-ID 702h\)",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x702, "00")] if k == START else []),
    ),
    Fault(
        "second node of our id, pre-operational",
        r"joint 2.*a second node has its id: a heartbeat that says pre-operational \(COB-ID 702h\)",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x702, "7F")] if k % BEAT == 0 else []),
    ),
    Fault(
        "second node of our id, operational",
        r"joint 2.*a second node has its id: twice as many heartbeats \(COB-ID 702h\)",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x702, "05")] if k % BEAT == 0 else []),
    ),
    Fault(
        "heartbeat of an unknown node",
        TOLERATED,
        0,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x709, "05")] if k % BEAT == 0 else []),
    ),
    Fault(
        "stray TPDO of our node",
        r"done; TPDO 2 of joint 2 .*COB-ID 282h",
        0,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x282, "0102")] if k % BEAT == 0 else []),
    ),
    Fault("bus-off that only the controller's state tells", "bus-off", 1, host=_silent_bus_off),
    Fault("bus-off", "bus-off", 1, cable=lambda: accompany(TPDO_2, lambda k: [error_frame(0x40)])),
    Fault("CRC errors", TOLERATED, 0, cable=lambda: accompany(TPDO_2, lambda k: [error_frame(0x08)])),
    Fault("SDO refused", "joint 2.*refuses to write", 1, cable=lambda: _refuse_sdo),
    Fault("SDO unanswered", r"no answer from joint 2", 1, cable=lambda: _swallow_sdo),
    Fault("joint blocked (collision)", r"joint 2.*(following error|torque)", 1, rig=always(_block)),
    Fault("encoder frozen", "following error", 1, rig=at(START, _freeze_encoder)),
    Fault("encoder jumps", r"joint 2: (position jump|following error)", 1, rig=at(START, _shift_encoder)),
    Fault(
        "another master disables a drive",
        r"joint 2: the drive left operation|following error",
        1,
        cable=lambda: accompany(SYNC, lambda k: [frame(RPDO_2, "000000000000")]),
    ),
    Fault(
        "another master stops a node (NMT)",
        "joint 2: no (valid )?answer|left operation",
        1,
        cable=lambda: accompany(SYNC, lambda k: [frame(0x000, "0202")] if k == START else []),
    ),
    Fault(
        "NMT stop by another master, heard",
        r'NMT "stop" to joint 2.*another master \(COB-ID 000h\)',
        1,
        events=happening("nmt_stop"),
    ),
    Fault("TPDO a byte short", SHORT % 7, 1, events=happening("short_tpdo")),
    Fault(
        "drive fault without EMCY",
        r"joint 2.*without EMCY; joint 2.*603F:00 says 0x2310 \(continuous over-current\)",
        1,
        events=happening("silent_fault"),
    ),
    Fault(
        "foreign SYNC", r"second SYNC.*COB-ID 080h", 1, cable=lambda: accompany(TPDO_2, lambda k: [frame(SYNC, "")])
    ),
    Fault(
        "foreign RPDO",
        r"RPDO that commands joint 2.*COB-ID 202h",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(RPDO_2, "000000000000")]),
    ),
    Fault(
        "SDO write by another master",
        r"SDO write to joint 2.*6040:00.*COB-ID 602h",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x602, "2B40600006000000")]),
    ),
    Fault(
        "heartbeat of another master", TOLERATED, 0, cable=lambda: accompany(TPDO_2, lambda k: [frame(0x77F, "05")])
    ),
    Fault("host stalls for 200 ms", "host came 200 ms late", 1, host=_stall),
)

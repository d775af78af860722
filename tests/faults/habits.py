"""Faults that begin before the motion: habits of drives, their dictionaries, units and PDOs, and warnings."""

import re
from collections.abc import Callable, Iterable

import can

from drivers.simulated.drive_state_machine import PowerState
from tests.faults.campaign import Fault, SabotagedRig
from tests.faults.canopen import BEAT, TOLERATED, at, frame, happening
from tests.faults.saboteurs import START, SYNC, TPDO_2, accompany

Change = Callable[[str], str]
"""Change of the text of an EDS."""
UNDER_VOLTAGE = 0x3220
_RPM_PER_SECOND, _THOUSANDTHS_OF_A_DEGREE = "0x00C00300", "0xFD410000"


def entry(section: str, **keys: str) -> Change:
    """Set keys of a section, e.g. DefaultValue."""

    def change(text: str) -> str:
        begin = text.index(f"[{section}]\n")
        end = text.find("\n[", begin) % (len(text) + 1)
        block = text[begin:end]
        for key, value in keys.items():
            block, count = re.subn(rf"(?m)^{key}=.*$", f"{key}={value}", block)
            assert count == 1, (section, key)
        return text[:begin] + block + text[end:]

    return change


def without(*indices: str) -> Change:
    """Remove objects with their sub-indices."""

    def change(text: str) -> str:
        sections = re.split(r"(?m)^(?=\[)", text)
        return "".join(section for section in sections if not section.startswith(tuple(f"[{i}" for i in indices)))

    return change


def with_guarding(text: str, instead_of: str = "1016") -> str:
    """Node guarding instead of a heartbeat consumer, or of another object."""
    sections = "".join(
        f"[{index}]\nParameterName=guarding\nObjectType=0x7\nDataType={kind}\nAccessType=rw\nDefaultValue=0\nPDOMapping=0\n\n"
        for index, kind in (("100C", "0x0006"), ("100D", "0x0005"))
    )
    return without(instead_of)(text) + "\n" + sections


def guarded_without_heartbeat(text: str) -> str:
    """Node guarding of a drive that watches its master's heartbeat and has none of its own."""
    return with_guarding(text, "1017")


def all_of(*changes: Change) -> Change:
    """One change after the other."""

    def change(text: str) -> str:
        for each in changes:
            text = each(text)
        return text

    return change


def _lose_guarding(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    return () if message.is_remote_frame and syncs >= START else (message,)


def _lose_guarding_answers(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    return () if message.arbitration_id == 0x702 and not from_master and syncs >= START else (message,)


def _unplug(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
    is_of_joint_2 = message.arbitration_id & 0x7F == 2 and message.arbitration_id > SYNC
    return () if is_of_joint_2 and syncs >= START else (message,)


def _lost_master(rig: SabotagedRig) -> None:
    """Fault 8130 of an earlier run, which a fault reset alone does not end."""
    for drive in rig.drives:
        drive.fail(0x8130)
        drive._motion.reset_blocked = True


def _leave_enabled(rig: SabotagedRig) -> None:
    rig.drives[1]._motion.state = PowerState.ENABLED


SECOND_TPDO = all_of(
    entry("1801sub1", DefaultValue="$NODEID+0x280"),
    entry("1801sub2", DefaultValue="255"),
    entry("1A01sub0", DefaultValue="1"),
    entry("1A01sub1", DefaultValue="0x60410010"),
)
"""A TPDO that is sent from power-up on."""
LONG_VOLTAGE = entry("2200sub1", DataType="0x0004")
POLLED = {"index": 0x2200, "sub": 1, "scale": 0.0005, "transfer": "sdo"}

NO_ANSWER = "no (valid )?answer for 50 ms"
MID_MOTION = {
    "limit_switch": "internal limit",
    "sync_loss": "0x8700",
    "quiet_reboot": NO_ANSWER,
    "pre_operational": NO_ANSWER,
    "quick_stop": "the drive left operation by itself",
    "flicker": "the drive left operation by itself",
    "turn_lost": "position jump",
    "bus_off": NO_ANSWER,
}
"""Troubles of a drive, by the names of the sim file, with the reason that is required."""
FROM_POWER_ON = {
    **MID_MOTION,
    "turn_lost": "(position jump|following error)",
    "short_tpdo": "has 7 bytes, 8 are mapped",
    "nmt_stop": 'NMT "stop"',
    "silent_fault": "603F:00 says 0x2310",
}

FAULTS: tuple[Fault, ...] = (
    Fault("TPDO a byte long", TOLERATED, 0, habits={"trouble": "long_tpdo"}),
    Fault("warning in mid-motion", TOLERATED, 0, rig=at(START, lambda r: r.drives[1].warn(0xFF01))),
    Fault(
        "storm of warnings",
        TOLERATED,
        0,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x082, "01FF000102030405")] * 5),
    ),
    Fault(
        "unknown code with an error register",
        r"joint 2.*EMCY 0xFF01",
        1,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x082, "01FF810000000000")]),
    ),
    Fault("fault before start", TOLERATED, 0, habits={"fault_at_power_on": UNDER_VOLTAGE}),
    # Lasts 50 requests by SDO, as many as a slow computer makes within fault_reset_timeout, too.
    Fault("slow fault reset", TOLERATED, 0, habits={"fault_at_power_on": UNDER_VOLTAGE, "fault_reset": 0.05}),
    Fault(
        "fault reset slower than allowed",
        r"fault 0x3220 \(DC link under-voltage\) is not reset within 0.2 s",
        1,
        habits={"fault_at_power_on": UNDER_VOLTAGE, "fault_reset": 60.0},
        drive={"fault_reset_timeout": 0.2},
    ),
    Fault(
        "fault reset ignored until NMT reset communication",
        TOLERATED,
        0,
        before=_lost_master,
        habits={"reset_after_heartbeat_loss": False},
        drive={"fault_reset_timeout": 0.2},
    ),
    Fault("drive left enabled by another program", TOLERATED, 0, before=_leave_enabled),
    Fault("enabling slower than allowed", "not enabled within 0.3 s", 1, habits={"enabling": 0.5}, enable=0.3),
    Fault("foreign PDOs from power-up", TOLERATED, 0, eds=SECOND_TPDO),
    Fault(
        "foreign PDO that the drive does not let go of",
        TOLERATED,
        0,
        eds=SECOND_TPDO,
        habits={"refuse_write": ["1801:01"]},
    ),
    Fault(
        "PDOs of an unknown node",
        r"done; TPDO 1 of node 37, which is not in the rig file \(COB-ID 1A5h\); TPDO 3 of node 37",
        0,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x1A5, "3712000000000000"), frame(0x3A5, "01")], first=0),
    ),
    Fault("COB-IDs with bit 30", TOLERATED, 0, habits={"cob_id_bits": 0x4000_0000}),
    Fault(
        "unit of acceleration against the rig file",
        r"1 rad/s\^2 of the joint: 200.535 by the drive \(rpm/s, 60AAh\), 27379.7 by units.acceleration",
        2,
        eds=entry("60AA", DefaultValue=_RPM_PER_SECOND),
        drive={"units": {"acceleration": "counts/s^2"}},
    ),
    Fault(
        "unit of position against the rig file",
        r"360000 by 60A8h of the drive, 8192 in the rig file",
        2,
        eds=entry("60A8", DefaultValue=_THOUSANDTHS_OF_A_DEGREE),
    ),
    Fault(
        "unknown unit of acceleration", r"60AAh = 00123456h is unknown", 2, eds=entry("60AA", DefaultValue="0x123456")
    ),
    Fault("unit of acceleration not stated", "nothing says the unit of accelerations", 2, eds=without("60AA")),
    Fault(
        "drive fault in mid-motion, quick stop in rpm/s",
        r"joint 2.*over-current \(0x2310\)",
        1,
        eds=entry("60AA", DefaultValue=_RPM_PER_SECOND),
        rig=at(START, lambda r: r.drives[1].fail(0x2310)),
    ),
    Fault(
        "drive fault in mid-motion, others stay in quick stop",
        r"joint 2.*over-current \(0x2310\)",
        1,
        habits={"allowed": {"605A": [6]}, "values": {"605A": 6}},
        drive={"quick_stop_option": 6},
        rig=at(START, lambda r: r.drives[1].fail(0x2310)),
    ),
    Fault(
        "value that the drive does not allow",
        r"605A:00.*the drive has 6; set quick_stop_option",
        1,
        habits={"allowed": {"605A": [6]}, "values": {"605A": 6}},
    ),
    Fault("voltage of 32 bits", TOLERATED, 0, eds=LONG_VOLTAGE),
    Fault("polled voltage of 32 bits", TOLERATED, 0, eds=LONG_VOLTAGE, drive={"voltage": POLLED}),
    Fault("object of safety missing", r"6066:00.*accept_missing", 2, eds=without("6066")),
    Fault(
        "object of safety missing, accepted", TOLERATED, 0, eds=without("6066"), drive={"accept_missing": ["6066"]}
    ),
    Fault("objects of convenience missing", TOLERATED, 0, eds=without("1006", "1008", "1017", "603F")),
    Fault("node guarding instead of a heartbeat", TOLERATED, 0, eds=with_guarding),
    Fault(
        "guarding requests lost on the bus",
        "master heartbeat lost|left operation",
        1,
        eds=with_guarding,
        cable=lambda: _lose_guarding,
    ),
    Fault("node guarding of drives without a heartbeat", TOLERATED, 0, eds=guarded_without_heartbeat),
    Fault(
        "answers to node guarding lost",
        r"joint 2.*no answer to node guarding; check the cable",
        1,
        eds=guarded_without_heartbeat,
        cable=lambda: _lose_guarding_answers,
    ),
    Fault(
        "guarded drive unplugged", f"joint 2: {NO_ANSWER}", 1, eds=guarded_without_heartbeat, cable=lambda: _unplug
    ),
    Fault(
        "heartbeats beside node guarding",
        r"joint 2.*a second node has its id: heartbeats beside the answers to node guarding \(COB-ID 702h\)",
        1,
        eds=guarded_without_heartbeat,
        cable=lambda: accompany(TPDO_2, lambda k: [frame(0x702, "05")] if k % BEAT == 0 else []),
    ),
    Fault("mode that the drive does not list", "supported modes: 0x1", 2, eds=entry("6502", DefaultValue="0x1")),
    Fault(
        "no zero reference in the statusword",
        "no zero reference",
        1,
        drive={"homed": {"index": 0x6041, "mask": 0x8000}},
    ),
    Fault(
        "zero reference in bit 15 of the statusword",
        TOLERATED,
        0,
        drive={"homed": {"index": 0x6041, "mask": 0x8000}},
        habits={"referenced_mask": 0x8000},
    ),
    *(
        Fault(f"{trouble}, in mid-motion", rf"joint 2.*{reason}", 1, events=happening(trouble))
        for trouble, reason in MID_MOTION.items()
    ),
    *(
        Fault(f"{trouble}, from power on", reason, 1, habits={"trouble": trouble, "trouble_after": 0.0})
        for trouble, reason in FROM_POWER_ON.items()
    ),
)

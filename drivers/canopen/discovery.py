"""Find the drives of a rig on a CAN bus, and check that no other master controls them."""

import time
from collections.abc import Sequence

from drivers.canopen import setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.protocol import SIMULATED, Identity
from recordings.errors import RunFailed

_PACE, _MARK = (0x5FFF, 1), (0x5FFF, 3)
"""Objects by which a simulated drive names itself, whatever its dictionary: the pace, and a text."""
_LISTENING_TIME = 0.2
"""Time to listen for another master before anything is sent [s]."""


def is_master_frame(arbitration_id: int) -> bool:
    """True for the frames that a CANopen master sends: NMT, SYNC, RPDO 1, SDO requests, its heartbeat."""
    function = arbitration_id & 0x780
    return arbitration_id in (0, 0x80, 0x700 + setup.MASTER_ID) or function in (0x200, 0x600)


def check_no_other_master(link: Link) -> None:
    """Raise RunFailed if another master controls the drives."""
    # In lockstep all drives are simulated and send nothing before they receive something.
    deadline = time.monotonic() + (_LISTENING_TIME if link.clock is None else 0.0)
    while (frame := link.receive(max(0.0, deadline - time.monotonic()))) is not None:
        if is_master_frame(frame[0]):
            raise RunFailed(
                f"another master is on this bus (frame {frame[0]:03X} seen); stop it first, or follow it with "
                "daq record --listen"
            )


def check_one_drive_per_node(axes: Sequence[CanopenAxis]) -> None:
    """Raise RunFailed unless exactly one drive answers under each node id."""
    answers = {axis.name: axis.sdo.count_answers() for axis in axes}
    missing = [name for name, count in answers.items() if count == 0]
    if missing:
        raise RunFailed(
            f"no answer from {', '.join(missing)}; check power, cable, termination, bit rate and the node ids "
            "in the rig file"
        )
    for name, count in answers.items():
        if count > 1:
            raise RunFailed(f"{name}: two drives answer under this node id; give each drive its own node id")


def identify(axis: CanopenAxis) -> Identity:
    """Read the identity of a drive.

    Raises:
        RunFailed: the device is no CiA 402 drive, or stops answering.
    """
    profile = axis.sdo.read(0x1000, 0, "<I") & 0xFFFF
    if profile != 402:
        raise RunFailed(f"{axis.name}: a CiA 402 drive expected, device profile {profile} found; check the node id")
    device = axis.sdo.read_text(0x1008)
    simulated = SIMULATED in (device, axis.sdo.read_text(*_MARK))
    return Identity(
        joint=axis.joint,
        address=f"node {axis.drive.node_id}",
        device=device or "a device without a name",
        vendor_id=axis.sdo.read_optional(0x1018, 1, "<I") or 0,
        product_code=axis.sdo.read_optional(0x1018, 2, "<I") or 0,
        revision=axis.sdo.read_optional(0x1018, 3, "<I") or 0,
        simulated=simulated,
        lockstep=simulated and axis.sdo.read(*_PACE, "<B") == 1,
    )

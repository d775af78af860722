"""Find the drives of a rig on a CAN bus, and check that no other master controls them."""

from collections.abc import Sequence
from dataclasses import replace

from drivers.canopen import requirements
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.sdo import ObjectRefused
from drivers.protocol import SIMULATED, Identity
from recordings.errors import RunFailed

_PACE, _STARTED, _MARK = (0x5FFF, 1), (0x5FFF, 2), (0x5FFF, 3)
"""Objects by which a simulated drive names itself, whatever its dictionary: pace, number of its start, and a text."""
_LISTENING_TIME = 0.2
"""Time to listen for another master before anything is sent [s]."""


def axes_by_node(axes: Sequence[CanopenAxis]) -> dict[int, list[CanopenAxis]]:
    """The axes of each node, by its id."""
    return {node: [a for a in axes if a.drive.node_id == node] for node in {a.drive.node_id: None for a in axes}}


def names(axes: Sequence[CanopenAxis]) -> str:
    """Names of the axes of one node, as text."""
    return " and ".join(axis.name for axis in axes)


def check_no_other_master(link: Link) -> None:
    """Raise RunFailed if another master controls the drives, by NMT, SYNC, RPDO 1, SDO or its heartbeat."""
    # In lockstep all drives are simulated and send nothing before they receive something.
    for seen, _ in link.frames(_LISTENING_TIME if link.clock is None else 0.0):
        if seen in (0, requirements.SYNC_ID, 0x700 + requirements.MASTER_ID) or seen & 0x780 in (0x200, 0x600):
            raise RunFailed(
                f"another master is on this bus (frame {seen:03X} seen); stop it first, or follow it with "
                "daq record --listen"
            )


def check_one_drive_per_node(axes: Sequence[CanopenAxis]) -> None:
    """Raise RunFailed unless exactly one drive answers under each node id."""
    answers = {axis.name: axis.sdo.count_answers() for axis in axes}
    missing = [name for name, count in answers.items() if count == 0]
    if missing:
        raise RunFailed(
            f"no answer from {', '.join(missing)}; check power, cable, termination, bit rate and the node ids "
            "in the rig file; a drive that has no node id yet gets one by daq rig lss"
        )
    for name, count in answers.items():
        if count > 1:
            raise RunFailed(f"{name}: two drives answer under this node id; give each drive its own node id")


def identify(axis: CanopenAxis) -> Identity:
    """Read the identity of a drive. Raises RunFailed if it stops answering."""
    device = axis.sdo.read_text(0x1008)
    simulated = SIMULATED in (device, axis.sdo.read_text(*_MARK))
    identity = Identity(
        joint=axis.joint,
        address=axis.drive.address,
        device=device or "a device without a name",
        vendor_id=axis.sdo.read_optional(0x1018, 1, "<I") or 0,
        product_code=axis.sdo.read_optional(0x1018, 2, "<I") or 0,
        revision=axis.sdo.read_optional(0x1018, 3, "<I"),
        simulated=simulated,
        lockstep=simulated and axis.sdo.read(*_PACE, "<B") == 1,
    )
    if identity.lockstep:
        # It has no past, and the same seed gives the same frames.
        return identity
    return replace(
        identity,
        serial_number=axis.sdo.read_optional(0x1018, 4, "<I") or 0,
        firmware=axis.sdo.read_text(0x100A),
        position=_position(axis),
        started=axis.sdo.read(*_STARTED, "<I") if simulated else 0,
    )


def _position(axis: CanopenAxis) -> float | None:
    """Where the joint stands [rad or m]; None where the drive does not say it, or has lost its zero."""
    try:
        if axis.is_homed() is False:
            return None
    except ObjectRefused:
        return None
    counts = axis.sdo.read_optional(0x6064, 0, "<i")
    return None if counts is None else axis.drive.to_position(counts)

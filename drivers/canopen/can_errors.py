"""Texts for what adapters say of errors: error frames, the state of the CAN controller, and errors of python-can."""

from contextlib import suppress
from typing import Any

import can

BUS_OFF = "bus-off: the CAN controller has switched itself off"
ERROR_PASSIVE = "error-passive: the CAN controller sees many errors, or only listens; check cable and bit rate"

# Class bits of the arbitration id, as SocketCAN has them (linux/can/error.h). Only bus-off ends a run; the others
# indicate a bad cable or a full bus.
_CLASSES: tuple[tuple[int, str], ...] = (
    (0x040, BUS_OFF),
    (0x020, "no acknowledge: nobody else is on the bus"),
    (0x010, "transceiver error"),
    (0x008, "protocol violation (CRC, bit, form or stuff error)"),
    (0x004, "controller problem"),
    (0x002, "arbitration lost"),
    (0x001, "transmit timeout"),
    (0x080, "bus error"),
    (0x100, "the controller has restarted"),
)
_DETAILS: dict[str, tuple[int, tuple[tuple[int, str], ...]]] = {
    "controller problem": (
        1,
        ((0x30, ERROR_PASSIVE), (0x0C, "error warning level reached"), (0x03, "buffer overflow")),
    ),
    "protocol violation (CRC, bit, form or stuff error)": (
        2,
        (
            (0x01, "bit error"),
            (0x02, "frame format error"),
            (0x04, "stuff error"),
            (0x18, "bit error"),
            (0x20, "overload"),
        ),
    ),
}
"""Byte of the data that says more, and the texts of its bits."""
_ERRORS = {
    **dict.fromkeys(("socketcan", "gs_usb", "virtual", "udp_multicast"), _CLASSES),
    "pcan": ((0x01, "bit error"), (0x02, "frame format error"), (0x04, "stuff error")),
}
"""Meanings of the arbitration id of an error frame, by the interface; the others have none that is known."""

# PCAN tells the state of its controller in bits, other interfaces by `bus.state`.
_PCAN_STATES = ((0x10, BUS_OFF), (0x40000, ERROR_PASSIVE))
_STATES = {can.BusState.ERROR: BUS_OFF, can.BusState.PASSIVE: ERROR_PASSIVE}


def decode(frame: can.Message, interface: str) -> str:
    """Text for the most serious error in an error frame of an interface of python-can."""
    text = _first(_ERRORS.get(interface, ()), frame.arbitration_id) or "an error frame without a kind that is known"
    at, bits = _DETAILS.get(text, (0, ()))
    return (_first(bits, frame.data[at]) if len(frame.data) > at else "") or text


def _first(texts: tuple[tuple[int, str], ...], bits: int) -> str:
    return next((text for bit, text in texts if bits & bit), "")


def controller(bus: Any) -> str:
    """State of the CAN controller as its adapter tells it; "": error-active, or it tells nothing.

    Many adapters send no error frame for bus-off.
    """
    # Vendors' libraries raise errors of their own.
    with suppress(Exception):
        return _first(_PCAN_STATES, bus.status()) if type(bus).__name__ == "PcanBus" else _STATES.get(bus.state, "")
    return ""


def explain(bus: Any, error: Exception, otherwise: str) -> str:
    """Why an adapter raised an error: bus-off where error or controller say so; `otherwise`: what else is known."""
    state = BUS_OFF if "busoff" in str(error).lower().replace("-", "").replace(" ", "") else controller(bus)
    return f"{state} ({error})" if state == BUS_OFF else f"{otherwise}: {error}" + (f"; {state}" if state else "")

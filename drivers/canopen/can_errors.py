"""Texts for CAN error frames as SocketCAN reports them (linux/can/error.h)."""

BUS_OFF = "bus-off: the CAN controller has switched itself off"

# Class bits of the arbitration id. Only bus-off ends a run; the others indicate a bad cable or a full bus.
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

# Second data byte of a controller problem.
_CONTROLLER: tuple[tuple[int, str], ...] = (
    (0x30, "error-passive"),
    (0x0C, "error warning level reached"),
    (0x03, "buffer overflow"),
)


def decode(arbitration_id: int, data: bytes) -> str:
    """Text for the most serious error in an error frame."""
    text = next((text for bit, text in _CLASSES if arbitration_id & bit), "unknown error frame")
    if text == "controller problem" and len(data) > 1:
        text = next((detail for bits, detail in _CONTROLLER if data[1] & bits), text)
    return text

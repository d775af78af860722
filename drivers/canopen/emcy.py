"""Texts for emergency messages (EMCY, CiA 301)."""

import struct

from canopen.emcy import EmcyError

_LAYOUT = struct.Struct("<HB5s")

# Frequent codes of CiA 301 and CiA 402; other codes fall back to their class.
_TEXTS: dict[int, str] = {
    0x2310: "continuous over-current",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x4310: "drive over-temperature",
    0x7305: "encoder error",
    0x8130: "master heartbeat lost",
    0x8250: "setpoints (RPDO) lost",
    0x8611: "following error",
    0x8612: "position limit",
}


def decode(data: bytes) -> tuple[int, str]:
    """Error code and text of an EMCY frame; code 0: error reset. A short frame is padded with zeros."""
    code, register, extra = _LAYOUT.unpack(data[:8].ljust(8, b"\0"))
    text = _TEXTS.get(code) or EmcyError(code, register, extra, 0.0).get_desc() or "unknown error"
    return code, text

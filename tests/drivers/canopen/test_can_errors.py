import pytest

from drivers.canopen import can_errors


@pytest.mark.parametrize(
    ("arbitration_id", "data", "text"),
    [
        (0x040, b"", can_errors.BUS_OFF),
        (0x0C8, b"", can_errors.BUS_OFF),
        (0x020, b"", "no acknowledge: nobody else is on the bus"),
        (0x004, b"\x00\x10", "error-passive"),
        (0x004, b"\x00\x08", "error warning level reached"),
        (0x004, b"\x00\x01", "buffer overflow"),
        (0x004, b"", "controller problem"),
        (0x088, b"", "protocol violation (CRC, bit, form or stuff error)"),
        (0x000, b"", "unknown error frame"),
    ],
)
def test_most_serious_error_is_reported(arbitration_id: int, data: bytes, text: str) -> None:
    assert can_errors.decode(arbitration_id, data) == text

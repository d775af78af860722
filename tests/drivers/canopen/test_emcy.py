import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen import emcy


@pytest.mark.parametrize(
    ("data", "code", "text"),
    [
        (bytes.fromhex("1186000000000000"), 0x8611, "following error"),
        (bytes.fromhex("3081110000000000"), 0x8130, "master heartbeat lost"),
        (bytes.fromhex("1043000000000000"), 0x4310, "drive over-temperature"),
        (bytes.fromhex("2043000000000000"), 0x4320, "drive temperature"),
        (bytes.fromhex("99f0000000000000"), 0xF099, "additional function"),
        (bytes.fromhex("01ff000000000000"), 0xFF01, "the manufacturer's own code"),
        (bytes.fromhex("0000000000000000"), 0x0000, "error reset or no error"),
        (b"\x11\x86", 0x8611, "following error"),
    ],
)
def test_decoded_error_code_and_text(data: bytes, code: int, text: str) -> None:
    message = emcy.decode(data)
    assert (message.code, message.text, message.details) == (code, text, "")


def test_bytes_of_the_manufacturer_are_shown() -> None:
    assert emcy.decode(bytes.fromhex("01ff000102030405")).details == " (manufacturer's bytes 01 02 03 04 05)"


@pytest.mark.parametrize(
    ("code", "register", "ends"),
    [
        (0x0000, 0x00, False),
        (0x0000, 0x10, False),
        (0x4310, 0x00, True),
        (0x8611, 0x21, True),
        (0x2351, 0x00, False),
        (0x8140, 0x00, False),
        (0x8140, 0x11, True),
        (0xFF01, 0x00, False),
        (0xFF01, 0x81, True),
        (0x1000, 0x00, False),
    ],
)
def test_a_warning_does_not_end_a_run(code: int, register: int, ends: bool) -> None:
    assert emcy.decode(code.to_bytes(2, "little") + bytes([register])).ends_run is ends


@given(st.binary(max_size=8))
def test_any_frame_has_a_text(data: bytes) -> None:
    assert emcy.decode(data).text

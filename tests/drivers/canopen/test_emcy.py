import pytest

from drivers.canopen import emcy


@pytest.mark.parametrize(
    ("data", "code", "text"),
    [
        (bytes.fromhex("1186000000000000"), 0x8611, "following error"),
        (bytes.fromhex("3081110000000000"), 0x8130, "master heartbeat lost"),
        (bytes.fromhex("1043000000000000"), 0x4310, "drive over-temperature"),
        (bytes.fromhex("2043000000000000"), 0x4320, "Temperature"),
        (bytes.fromhex("0000000000000000"), 0x0000, "Error Reset / No Error"),
        (b"\x11\x86", 0x8611, "following error"),
    ],
)
def test_decoded_error_code_and_text(data: bytes, code: int, text: str) -> None:
    assert emcy.decode(data) == (code, text)

import math

import pytest

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.poll import VoltagePoll
from drivers.canopen.sdo import Sdo
from recordings.rig import Drive, Voltage
from tests.drivers.canopen.scripted import ScriptedBus

REQUEST = (0x601, "40 30 20 00 00 00 00 00")


def polled(answer: str, *, signed: bool | None = None) -> float:
    """Voltage [V] by an answer to the poll of an object with 1 mV per count."""
    voltage = Voltage(index=0x2030, sub=0, scale=0.001, transfer="sdo", signed=signed)
    link = Link(ScriptedBus([(REQUEST, [])]))
    axis = CanopenAxis(1, Drive(node_id=1, voltage=voltage), Sdo(1, "joint 1", link, lambda *frame: None))
    poll = VoltagePoll([axis], link)
    poll.request(0)
    poll.take_response(axis, bytes.fromhex(answer))
    return axis.voltage


@pytest.mark.parametrize(
    ("answer", "signed", "volts"),
    [
        ("43 30 20 00 70 11 01 00", None, 70.0),  # four bytes: 70,000
        ("43 30 20 00 90 ee fe ff", None, -70.0),
        ("4b 30 20 00 f0 d8 00 00", None, -10.0),  # two bytes
        ("4b 30 20 00 f0 d8 00 00", False, 55.536),
        ("4f 30 20 00 fe 00 00 00", None, -0.002),  # one byte
        ("42 30 20 00 f0 d8 00 00", None, -10.0),  # size not indicated: that of the dictionary
    ],
)
def test_size_and_sign_of_the_answer(answer: str, signed: bool | None, volts: float) -> None:
    assert polled(answer, signed=signed) == pytest.approx(volts)


@pytest.mark.parametrize("answer", ["80 30 20 00 00 00 02 06", "43 31 20 00 70 11 01 00", "41 30 20 00 09 00 00 00"])
def test_abort_and_other_answers_give_no_voltage(answer: str) -> None:
    assert math.isnan(polled(answer))

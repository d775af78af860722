from types import SimpleNamespace

import can
import pytest

from drivers.canopen import can_errors


def _frame(arbitration_id: int, data: bytes) -> can.Message:
    return can.Message(arbitration_id=arbitration_id, data=data, is_error_frame=True)


@pytest.mark.parametrize(
    ("arbitration_id", "data", "text"),
    [
        (0x040, b"", can_errors.BUS_OFF),
        (0x0C8, b"", can_errors.BUS_OFF),
        (0x020, b"", "no acknowledge: nobody else is on the bus"),
        (0x004, b"\x00\x10", can_errors.ERROR_PASSIVE),
        (0x004, b"\x00\x08", "error warning level reached"),
        (0x004, b"\x00\x01", "buffer overflow"),
        (0x004, b"", "controller problem"),
        (0x088, b"", "protocol violation (CRC, bit, form or stuff error)"),
        (0x088, b"\x00\x00\x04", "stuff error"),
        (0x000, b"", "an error frame without a kind that is known"),
    ],
)
def test_most_serious_error_is_reported(arbitration_id: int, data: bytes, text: str) -> None:
    assert can_errors.decode(_frame(arbitration_id, data), "socketcan") == text


@pytest.mark.parametrize(
    ("arbitration_id", "interface", "text"),
    [
        (0x004, "gs_usb", "controller problem"),
        (0x004, "pcan", "stuff error"),
        (0x008, "pcan", "an error frame without a kind that is known"),
        (0x040, "kvaser", "an error frame without a kind that is known"),
    ],
)
def test_error_frames_are_read_as_their_adapter_writes_them(arbitration_id: int, interface: str, text: str) -> None:
    assert can_errors.decode(_frame(arbitration_id, b""), interface) == text


class PcanBus:
    """Has a state by configuration, and another one of the controller."""

    state = can.BusState.ACTIVE

    def __init__(self, status: int) -> None:
        self.status = lambda: status


class Mute:
    """Cannot be asked."""

    @property
    def state(self) -> can.BusState:
        raise OSError("no device")


@pytest.mark.parametrize(
    ("bus", "text"),
    [
        (PcanBus(0), ""),
        (PcanBus(0x90), can_errors.BUS_OFF),
        (PcanBus(0x40008), can_errors.ERROR_PASSIVE),
        (Mute(), ""),
        (SimpleNamespace(state=can.BusState.ACTIVE), ""),
        (SimpleNamespace(state=can.BusState.ERROR), can_errors.BUS_OFF),
    ],
)
def test_state_of_the_controller_is_what_the_adapter_tells(bus: object, text: str) -> None:
    assert can_errors.controller(bus) == text


@pytest.mark.parametrize(
    ("state", "error", "text"),
    [
        (can.BusState.ACTIVE, "Network is down", "not sent: Network is down"),
        (can.BusState.PASSIVE, "full", f"not sent: full; {can_errors.ERROR_PASSIVE}"),
        (can.BusState.ERROR, "full", f"{can_errors.BUS_OFF} (full)"),
        # PCAN and IXXAT
        (
            can.BusState.ACTIVE,
            "Bus error: the CAN controller is in bus-off state",
            f"{can_errors.BUS_OFF} (Bus error: the CAN controller is in bus-off state)",
        ),
        (
            can.BusState.ACTIVE,
            "Controller is in BUSOFF state",
            f"{can_errors.BUS_OFF} (Controller is in BUSOFF state)",
        ),
    ],
)
def test_errors_of_adapters_that_mean_bus_off_say_so(state: can.BusState, error: str, text: str) -> None:
    assert can_errors.explain(SimpleNamespace(state=state), can.CanOperationError(error), "not sent") == text

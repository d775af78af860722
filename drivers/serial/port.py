"""Open serial ports by name: the system's ports, and those simulated inside this program."""

from contextlib import suppress

import serial

from recordings.errors import BadInput

_WRITE_TIMEOUT = 0.5
"""Time after which a port that does not accept a command is lost [s]."""

simulated: dict[str, str] = {}
"""Device of each pseudo-terminal that is simulated inside this program, by name."""


def open_port(name: str, baud: int) -> serial.Serial:
    """Open a port with 8 data bits and no parity for non-blocking reads.

    Raises:
        BadInput: the port does not exist, is in use, or does not support the baud rate.
    """
    try:
        port = serial.Serial(simulated.get(name, name), baud, timeout=0, write_timeout=_WRITE_TIMEOUT, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise BadInput(
            f"serial port '{name}' cannot be opened: {error}; check bus.ports, bus.baud and your permission to use it"
        ) from None
    # USB adapters buffer characters for 16 ms unless this is switched off; pseudo-terminals have no such setting.
    with suppress(ValueError, OSError, NotImplementedError):
        port.set_low_latency_mode(True)
    return port

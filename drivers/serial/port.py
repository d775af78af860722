"""Opening serial ports by name: the system's own, and the ones that are simulated inside this program."""

from contextlib import suppress

import serial

from recordings.errors import BadInput

_WRITE_TIMEOUT = 0.5
"""A port that does not take a command for this long is lost [s]."""

simulated: dict[str, str] = {}
"""Device of each pseudo-terminal that somebody in this program serves under a name."""


def open_port(name: str, baud: int) -> serial.Serial:
    """Open a port, 8 data bits, no parity, for reads that do not wait.

    Raises:
        BadInput: it does not exist, is in use, or cannot do this baud rate.
    """
    try:
        port = serial.Serial(simulated.get(name, name), baud, timeout=0, write_timeout=_WRITE_TIMEOUT, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise BadInput(
            f"serial port '{name}' cannot be opened: {error}; check bus.ports, bus.baud and your right to use it"
        ) from None
    # USB adapters collect characters for 16 ms unless they are told not to; pseudo-terminals know nothing of it.
    with suppress(ValueError, OSError, NotImplementedError):
        port.set_low_latency_mode(True)
    return port

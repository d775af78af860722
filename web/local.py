"""Local server: the socket on which it listens, and its address with the token."""

import socket

from recordings.errors import BadInput

HOST = "127.0.0.1"


def listen(port: int | None = None) -> socket.socket:
    """Return a socket that listens on `port`, or on any free port.

    Raises:
        BadInput: the port is in use.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port or 0))
        listening.listen()  # a browser that connects before the server is ready waits
    except OSError as error:
        listening.close()
        raise BadInput(f"a free port expected, {port} found in use ({error.strerror}); choose another") from None
    return listening


def address(listening: socket.socket, token: str) -> str:
    """Return the address that a browser opens; `web.security.Guard` moves the token into a cookie."""
    return f"http://{HOST}:{listening.getsockname()[1]}/?token={token}"

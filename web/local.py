"""A server for whoever has the token, on this machine only: the socket it listens on, and its address."""

import socket

from recordings.errors import BadInput

HOST = "127.0.0.1"


def listen(port: int | None = None) -> socket.socket:
    """A socket that listens on `port`, or on any that is free.

    Raises:
        BadInput: the port is taken.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port or 0))
        listening.listen()  # a browser that comes before the server is ready waits
    except OSError as error:
        listening.close()
        raise BadInput(f"a free port expected, {port} found taken ({error.strerror}); choose another") from None
    return listening


def address(listening: socket.socket, token: str) -> str:
    """What a browser opens; `web.security.Guard` moves the token into a cookie."""
    return f"http://{HOST}:{listening.getsockname()[1]}/?token={token}"

"""Local server: the socket on which it listens, its address with the token, and a link for the browser."""

import os
import re
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

from recordings.errors import BadInput

HOST = "127.0.0.1"
LINK_PREFIX = "open-page-"
"""Of the names of the files that lead a browser to the page."""
_PORT = re.compile(rf"http://{re.escape(HOST)}:(\d+)/")


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
    """Return the address that a browser opens; `delta_web.security.Guard` moves the token into a cookie."""
    return f"http://{HOST}:{listening.getsockname()[1]}/?token={token}"


@contextmanager
def link(address: str, folder: Path) -> Iterator[str]:
    """Yield the link of a file in `folder` that leads a browser to `address`; the file is removed in the end.

    Everyone on this machine sees how a browser was started, but only the owner of the file can read the token in it.
    """
    # Browsers in a sandbox of their own see the folders of the user, but not those for temporary files.
    where = folder if os.access(folder, os.W_OK) else None
    _remove_left_over(folder, urlsplit(address).port)
    with tempfile.NamedTemporaryFile("w", dir=where, prefix=LINK_PREFIX, suffix=".html", encoding="utf-8") as file:
        file.write(f'<!doctype html><meta http-equiv="refresh" content="0; url={address}">\n')
        file.flush()
        yield Path(file.name).as_uri()


def _remove_left_over(folder: Path, own_port: int | None) -> None:
    """Remove the files that servers have left in `folder` which were killed: their port is ours now, or nobody's."""
    for file in folder.glob(f"{LINK_PREFIX}*.html"):
        with suppress(OSError):
            found = _PORT.search(file.read_text(encoding="utf-8", errors="replace"))
            if found and (int(found[1]) == own_port or not _answers(int(found[1]))):
                file.unlink()


def _answers(port: int) -> bool:
    try:
        with socket.create_connection((HOST, port), timeout=1.0):
            return True
    except OSError:
        return False

"""The link that a browser is handed: only the owner can read what is behind it, and it leads to the page."""

import socket
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlparse

import pytest
import uvicorn

from tests import chromium
from tests.web.test_security import GUARDED, TOKEN
from web import local


@pytest.fixture
def listening() -> Iterator[socket.socket]:
    """A socket on which the guarded application answers."""
    with local.listen() as each:
        server = uvicorn.Server(uvicorn.Config(GUARDED, log_level="warning", lifespan="off"))
        thread = threading.Thread(target=server.run, args=([each],))
        thread.start()
        yield each
        server.should_exit = True
        thread.join()


def forward(to: int) -> int:
    """Pass on what comes to another port, as ssh does; return that port."""
    entrance = socket.create_server((local.HOST, 0))

    def pump(source: socket.socket, target: socket.socket) -> None:
        while data := source.recv(65536):
            target.sendall(data)
        target.close()

    def accept() -> None:
        while True:
            near, far = entrance.accept()[0], socket.create_connection((local.HOST, to))
            for pair in ((near, far), (far, near)):
                threading.Thread(target=pump, args=pair, daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    return int(entrance.getsockname()[1])


def test_the_file_belongs_to_its_owner_alone_and_is_removed(listening: socket.socket, tmp_path: Path) -> None:
    with local.link(local.address(listening, TOKEN), tmp_path) as link:
        assert TOKEN not in link
        file = Path(urlparse(link).path)
        assert file.parent == tmp_path
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("forwarded", [False, True])
def test_a_browser_reaches_the_page(forwarded: bool, listening: socket.socket, tmp_path: Path) -> None:
    address = local.address(listening, TOKEN)
    if forwarded:
        port = listening.getsockname()[1]
        address = address.replace(str(port), str(forward(port)))
    with local.link(address, tmp_path) as link, chromium.tab() as page:
        page.goto(link)
        page.get_by_text("inside 0").wait_for()
        assert page.url == address.partition("?")[0]

"""The link that a browser is handed: only the owner can read what is behind it, and it leads to the page."""

import socket
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlparse

import pytest
import uvicorn

from delta_web import local
from tests import chromium
from tests.delta_web.test_security import GUARDED, TOKEN


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


def test_the_file_belongs_to_its_owner_alone_and_is_removed(listening: socket.socket, tmp_path: Path) -> None:
    with local.link(local.address(listening, TOKEN), tmp_path) as link:
        assert TOKEN not in link
        file = Path(urlparse(link).path)
        assert file.parent == tmp_path
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert not list(tmp_path.iterdir())


def test_what_servers_left_that_were_killed_is_removed(listening: socket.socket, tmp_path: Path) -> None:
    with local.listen() as other, local.listen() as ended:
        addresses = [local.address(each, TOKEN) for each in (listening, other, ended)]
        ended.close()
        for name, address in zip("abc", addresses, strict=True):
            (tmp_path / f"{local.LINK_PREFIX}{name}.html").write_text(address)
        (tmp_path / "report.html").write_text(addresses[2])
        with local.link(addresses[0], tmp_path):
            pass
    assert [path.name for path in sorted(tmp_path.iterdir())] == [f"{local.LINK_PREFIX}b.html", "report.html"]


@pytest.mark.slow
def test_a_browser_reaches_the_page(listening: socket.socket, tmp_path: Path) -> None:
    address = local.address(listening, TOKEN)
    with local.link(address, tmp_path) as link, chromium.tab() as page:
        page.goto(link)
        page.get_by_text("inside 0").wait_for()
        assert page.url == address.partition("?")[0]

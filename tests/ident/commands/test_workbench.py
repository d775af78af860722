"""`ident workbench` as a user starts it; the page itself is tested in tests/ident/workbench."""

import signal
import socket
import subprocess
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from tests.conftest import Runner, launcher
from tests.patience import patient


@pytest.mark.slow
def test_an_occupied_port_is_refused(ident: Runner) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        done = ident("workbench", "--no-browser", "--port", server.getsockname()[1])
    assert done.code == 2
    assert "a free port expected" in done.err


@pytest.mark.slow
def test_it_serves_this_machine_only_and_ends_with_ctrl_c(tmp_path: Path) -> None:
    command = [*launcher("ident"), "workbench", "--no-browser"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    address = process.stdout.readline().split()[1]
    bare = address.partition("?")[0]
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(bare, timeout=patient(60))
    port = int(bare.rstrip("/").rpartition(":")[2])
    for host in {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}:
        if not str(host).startswith("127."):
            with pytest.raises(OSError, match="refused"):
                socket.create_connection((host, port), timeout=5)
    cookies = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with cookies.open(address, timeout=patient(60)):  # leaves the cookie
        pass
    with cookies.open(bare, timeout=patient(60)) as page:
        text = page.read().decode()
    assert "delta-workbench" in text
    for attribute in ('src="http', 'href="http', 'from "http', "import('http"):
        assert attribute not in text, "everything comes from here"
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=patient(120))
    assert process.returncode == 0, out
    assert "Traceback" not in out
    assert out.splitlines()[-1].startswith("next: daq record")

"""Live view in the browser: a read-only server of the status lines of a run.

The server is a process of its own (`python -m daq.live.page`), fed by `daq.live.viewer`.
"""

import asyncio
import importlib.resources
import json
import os
import socket
import sys
import threading
import webbrowser
from collections import deque
from collections.abc import AsyncIterator, Iterable
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI, Response
from fastapi.responses import StreamingResponse

from daq.live.viewer import END_TIMEOUT
from delta_web import local
from delta_web.palette import JOINTS, MEASURED
from delta_web.security import Guard

_MAX_LINES = 300
"""Number of last lines that are kept for a page that is opened late."""
_INTERVAL = 0.1
"""Time between two checks for new lines [s]."""
_ASSETS = {
    "/": ("page.html", "text/html"),
    "/page.js": ("page.js", "text/javascript"),
    "/page.css": ("page.css", "text/css"),
}
_KILLED = {"killed": True}


class RunBroadcast:
    """Broadcast of the status lines of a run to any number of pages; each page reads at its own speed."""

    def __init__(self, run: dict[str, Any]) -> None:
        self._first = json.dumps({"run": run, "colours": JOINTS, "grey": MEASURED})
        self._lines: deque[tuple[int, str]] = deque(maxlen=_MAX_LINES)
        """Last lines, with their numbers."""
        self._reports: deque[tuple[int, str]] = deque(maxlen=_MAX_LINES)
        """Earlier lines with a warning or an error."""
        self._count = 0
        self.finished = False
        self.browser_expected = True
        """A browser is to open a page: it may be slow, and some return from their start only when they are closed."""
        self.pages = 0
        """Number of open pages."""
        self.pages_served = 0
        """Number of pages that have received the end of the run."""

    def listen(self, lines: Iterable[str]) -> None:
        """Read all lines until the end of the run."""
        last = "{}"
        for line in lines:
            last = line.strip()
            self._add(last)
        if "ended" not in json.loads(last):
            self._add(json.dumps(_KILLED))
        self.finished = True

    def _add(self, line: str) -> None:
        if len(self._lines) == _MAX_LINES and _has_warning(self._lines[0][1]):
            self._reports.append(self._lines[0])
        self._lines.append((self._count, line))
        self._count += 1

    def _since(self, number: int) -> list[tuple[int, str]]:
        # The last lines first, of which the other thread may make earlier ones meanwhile.
        return sorted(line for line in {*self._lines, *self._reports} if line[0] >= number)

    async def events(self) -> AsyncIterator[str]:
        """Generate server-sent events: the start of the run, warnings, the last lines, then every new line until the
        end."""
        self.pages += 1
        try:
            yield f"data: {self._first}\n\n"
            sent, finished = 0, False
            while not finished:
                finished, new = self.finished, self._since(sent)
                yield "".join(f"data: {line}\n\n" for _, line in new)
                sent = new[-1][0] + 1 if new else sent
                await asyncio.sleep(_INTERVAL)
            self.pages_served += 1
        finally:
            self.pages -= 1


def _has_warning(line: str) -> bool:
    return any(not report.startswith("info") for report in json.loads(line).get("reports", ()))


def application(broadcast: RunBroadcast) -> FastAPI:
    """Build the application that serves the page, its assets and its events."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    def offer(path: str, content: str, kind: str) -> None:
        app.add_api_route(path, lambda: Response(content, media_type=kind), methods=["GET"])

    assets = importlib.resources.files("daq.live") / "assets"
    for path, (name, kind) in _ASSETS.items():
        offer(path, (assets / name).read_text(encoding="utf-8"), kind)
    plotly = importlib.resources.files("plotly") / "package_data" / "plotly.min.js"
    offer("/plotly.js", plotly.read_text(encoding="utf-8"), "text/javascript")

    @app.get("/events")
    async def events() -> StreamingResponse:
        return StreamingResponse(
            broadcast.events(), media_type="text/event-stream", headers={"cache-control": "no-store"}
        )

    return app


async def serve(broadcast: RunBroadcast, token: str, listening: socket.socket) -> None:
    """Serve until the run is over and all open pages have received its end."""
    app = Guard(application(broadcast), token)
    server = uvicorn.Server(
        uvicorn.Config(app, log_level="error", access_log=False, lifespan="off", timeout_graceful_shutdown=1)
    )

    async def end() -> None:
        while not broadcast.finished:
            await asyncio.sleep(_INTERVAL)
        until = asyncio.get_running_loop().time() + END_TIMEOUT
        while (
            broadcast.pages or (broadcast.browser_expected and not broadcast.pages_served)
        ) and asyncio.get_running_loop().time() < until:
            await asyncio.sleep(_INTERVAL)
        server.should_exit = True

    await asyncio.gather(server.serve(sockets=[listening]), end())


def main() -> None:
    """Serve the status lines on stdin."""
    os.nice(5)  # the cycle comes first
    # A browser started by this process must not read these lines.
    lines = os.fdopen(os.dup(sys.stdin.fileno()), encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_RDONLY), sys.stdin.fileno())
    first = json.loads(lines.readline())
    broadcast = RunBroadcast(first["run"])
    threading.Thread(target=broadcast.listen, args=(lines,), daemon=True).start()
    with (
        socket.socket(fileno=first["listening"]) as listening,
        local.link(local.address(listening, first["token"]), Path(first["folder"])) as link,
    ):

        def browse() -> None:
            broadcast.browser_expected = webbrowser.open(link)

        # In a thread: with some browsers the call returns only when they are closed.
        threading.Thread(target=browse, daemon=True).start()
        asyncio.run(serve(broadcast, first["token"], listening))


if __name__ == "__main__":
    main()

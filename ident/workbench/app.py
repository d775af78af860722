"""HTTP server of the page. It listens on this machine only and requires the token."""

import secrets
import socket
import webbrowser
from contextlib import ExitStack, suppress

import uvicorn
from fastapi import FastAPI, Request
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse
from nicegui import ui

from delta_web import local
from delta_web.security import Guard
from ident.workbench.pages.shell import build
from ident.workbench.state.project import Access
from ident.workbench.state.session import WorkbenchSession
from recordings.errors import BadInput

_PATIENCE = 18.0
"""A frozen browser counts as absent after 1.2 times as long [s], and moving drives are stopped 20 s later."""
_KEPT = 900.0
"""Time for which the page of an absent browser is kept [s]: one that comes back goes on where it was, and what was
pressed meanwhile counts."""
_SANDBOX = {"content-security-policy": "sandbox allow-scripts allow-downloads"}
"""A report runs its scripts apart from the page, which can set drives in motion."""


def guarded_app(session: WorkbenchSession, token: str) -> Guard:
    """Return the page of `session` as an ASGI application behind the token guard."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @ui.page("/", title="delta-workbench", reconnect_timeout=_KEPT)
    def page() -> None:
        build(session)

    @app.exception_handler(BadInput)
    def refuse(_: Request, error: BadInput) -> JSONResponse:
        return JSONResponse({"detail": str(error)}, 404)

    @app.get("/reports/{name}")
    def report(name: str) -> FileResponse:
        return FileResponse(session.folder.report(name), media_type="text/html", headers=_SANDBOX)

    @app.get("/fleet")
    def fleet() -> HTMLResponse:
        if session.fleet is None:
            raise BadInput("no store of a fleet is open; start the workbench with --store DIR")
        return HTMLResponse(session.fleet.page(), headers=_SANDBOX)

    # NiceGUI brings all assets; nothing is loaded from a network.
    ui.run_with(app, title="delta-workbench", show_welcome_message=False, reconnect_timeout=_PATIENCE)
    return Guard(app, token)


def serve(session: WorkbenchSession, port: int | None, browser: bool) -> None:
    """Serve the page until Ctrl-C.

    port: None means the one on which the page of this folder was, so that an open tab finds it, or any that is free.

    Raises:
        BadInput: the port is in use.
    """
    before = session.project.access()
    listening = _listen(port, before)
    now = listening.getsockname()[1]
    # Whoever has taken the port of before may have been sent its token, by a tab that was open.
    token = before.token if before and before.port == now else secrets.token_urlsafe(24)
    session.project.keep_access(Access(now, token))
    address = local.address(listening, token)
    app = guarded_app(session, token)
    config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=1)
    print(f"workbench: {address}\nOnly this machine can open it. Press Ctrl-C to quit.", flush=True)
    if before and before.port != now:
        print(f"This page was on port {before.port}: open the address above in place of an open tab.", flush=True)
    print(*filter(None, (session.project.says, session.interrupted)), sep="\n", flush=True)
    session.jobs.worker.prepare()
    with ExitStack() as stack:
        stack.callback(session.close)
        if browser:
            webbrowser.open(stack.enter_context(local.link(address, session.folder.root)))
        with suppress(KeyboardInterrupt):
            uvicorn.Server(config).run(sockets=[listening])


def _listen(port: int | None, before: Access | None) -> socket.socket:
    if port is None and before:
        with suppress(BadInput):  # another program has taken it
            return local.listen(before.port)
    return local.listen(port)

"""HTTP server of the page. It listens on this machine only and requires the token."""

import secrets
import webbrowser
from contextlib import ExitStack, suppress

import uvicorn
from fastapi import FastAPI, HTTPException
from fastapi.responses import FileResponse, HTMLResponse
from nicegui import ui

from ident.workbench.pages.shell import build
from ident.workbench.state.session import WorkbenchSession
from recordings.errors import BadInput
from web import local
from web.security import Guard

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

    @app.get("/reports/{name}")
    def report(name: str) -> FileResponse:
        try:
            return FileResponse(session.export.report(name), media_type="text/html", headers=_SANDBOX)
        except BadInput as error:
            raise HTTPException(404, str(error)) from None

    @app.get("/fleet")
    def fleet() -> HTMLResponse:
        if session.fleet is None:
            raise HTTPException(404, "no store of a fleet is open; start the workbench with --store DIR")
        try:
            return HTMLResponse(session.fleet.page(), headers=_SANDBOX)
        except BadInput as error:
            raise HTTPException(404, str(error)) from None

    # NiceGUI brings all assets; nothing is loaded from a network.
    ui.run_with(app, title="delta-workbench", show_welcome_message=False, reconnect_timeout=_PATIENCE)
    return Guard(app, token)


def serve(session: WorkbenchSession, port: int | None, browser: bool) -> None:
    """Serve the page until Ctrl-C.

    Raises:
        BadInput: the port is in use.
    """
    listening = local.listen(port)
    token = secrets.token_urlsafe(24)
    address = local.address(listening, token)
    app = guarded_app(session, token)
    config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=1)
    print(f"workbench: {address}\nOnly this machine can open it. Press Ctrl-C to quit.", flush=True)
    session.jobs.worker.prepare()
    with ExitStack() as stack:
        stack.callback(session.close)
        if browser:
            webbrowser.open(stack.enter_context(local.link(address, session.folder.root)))
        with suppress(KeyboardInterrupt):
            uvicorn.Server(config).run(sockets=[listening])

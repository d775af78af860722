"""HTTP server of the page. It listens on this machine only and requires the token."""

import secrets
import webbrowser

import uvicorn
from fastapi import FastAPI
from nicegui import ui

from ident.workbench.pages.shell import build
from ident.workbench.session import WorkbenchSession
from web import local
from web.security import Guard


def guarded_app(session: WorkbenchSession, token: str, port: int) -> Guard:
    """Return the page of `session` as an ASGI application behind the token guard."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @ui.page("/", title="delta-workbench")
    def page() -> None:
        build(session)

    # NiceGUI brings all assets; nothing is loaded from a network.
    ui.run_with(app, title="delta-workbench", show_welcome_message=False, reconnect_timeout=10.0)
    return Guard(app, token, port)


def serve(session: WorkbenchSession, port: int | None, browser: bool) -> None:
    """Serve the page until Ctrl-C.

    Raises:
        BadInput: the port is in use.
    """
    listening = local.listen(port)
    token = secrets.token_urlsafe(24)
    address = local.address(listening, token)
    app = guarded_app(session, token, listening.getsockname()[1])
    config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=1)
    print(f"workbench: {address}\nOnly this machine can open it. Press Ctrl-C to quit.", flush=True)
    session.jobs.worker.prepare()
    if browser:
        webbrowser.open(address)
    try:
        uvicorn.Server(config).run(sockets=[listening])
    except KeyboardInterrupt:
        pass
    finally:
        session.close()

"""The server behind the page: on this machine only, for whoever has the token."""

import secrets
import webbrowser

import uvicorn
from fastapi import FastAPI
from nicegui import ui

from ident.workbench.pages.shell import build
from ident.workbench.session import Session
from web import local
from web.security import Guard


def guarded(session: Session, token: str, port: int) -> Guard:
    """The page of `session` as an ASGI application."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @ui.page("/", title="delta-workbench")
    def page() -> None:
        build(session)

    # What the page needs comes with NiceGUI; nothing is loaded from elsewhere.
    ui.run_with(app, title="delta-workbench", show_welcome_message=False, reconnect_timeout=10.0)
    return Guard(app, token, port)


def serve(session: Session, port: int | None, browser: bool) -> None:
    """Until Ctrl-C.

    Raises:
        BadInput: the port is taken.
    """
    listening = local.bound(port)
    token = secrets.token_urlsafe(24)
    address = local.address(listening, token)
    app = guarded(session, token, listening.getsockname()[1])
    config = uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=1)
    print(f"workbench: {address}\nOnly this machine can open it. Ctrl-C ends.", flush=True)
    session.prepare()
    if browser:
        webbrowser.open(address)
    try:
        uvicorn.Server(config).run(sockets=[listening])
    except KeyboardInterrupt:
        pass
    finally:
        session.close()

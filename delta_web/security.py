"""Access control: only a browser on this machine with the token may use the page.

A page of another site in the same browser sends its own Origin and no cookie. A foreign name that resolves to this
machine (DNS rebinding) is recognised by its Host. The port may be any: over ssh it is that of the other machine.
"""

import hmac
import re
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from fastapi import HTTPException
from fastapi.requests import HTTPConnection
from fastapi.responses import HTMLResponse, PlainTextResponse, Response

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]

MAX_BODY_BYTES = 256 * 2**20
"""Limit of an upload; larger recordings are copied into the folder by hand [bytes]."""
_HOST = re.compile(r"(?:127\.0\.0\.1|localhost):(?P<port>\d{1,5})")
_SAFE_METHODS = ("GET", "HEAD")
_HEADERS = {
    "content-security-policy": "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; connect-src 'self' "
    "data: blob:; frame-ancestors 'none'; form-action 'self'; base-uri 'self'; object-src 'none'",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}
_TO_THE_PAGE = '<!doctype html><meta http-equiv="refresh" content="0; url=/">'


class Guard:
    """Pass requests on to `app` if they carry the token, name this host, and come from its own pages."""

    def __init__(self, app: App, token: str, max_body_bytes: int = MAX_BODY_BYTES) -> None:
        self._app, self._token, self._max_body_bytes = app, token, max_body_bytes

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """See ASGI."""
        answer = None if scope["type"] == "lifespan" else self._answer(HTTPConnection(scope))
        if answer and scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": bytes(answer.body).decode()})
        elif answer:
            await answer(scope, receive, send)
        elif scope["type"] == "http":
            await self._forward(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    def _answer(self, asked: HTTPConnection) -> Response | None:
        """Return what is said in place of the page: a refusal, or the way to the page; None: the page itself."""
        host = _HOST.fullmatch(asked.headers.get("host", ""))
        if host is None:
            return _refusal(421, "Host 127.0.0.1 or localhost with a port expected.")
        here, method = f"http://{host[0]}", asked.get("method")  # a WebSocket has none
        if asked.headers.get("origin", here if method in _SAFE_METHODS else "none") != here:
            return _refusal(403, "A request from this page expected, another origin found.")
        length = asked.headers.get("content-length", "0")
        if not length.isdigit() or int(length) > self._max_body_bytes:
            return _refusal(413, self._too_long)
        cookie = f"token_{host['port']}"
        if self._is_token(asked.cookies.get(cookie)):
            return None
        if method == "GET" and self._is_token(asked.query_params.get("token")):
            return self._way_to_the_page(cookie)
        return _refusal(403, "Open the printed address; it contains the token.")

    @property
    def _too_long(self) -> str:
        limit = self._max_body_bytes // 2**20
        return f"At most {limit} MiB can be sent; copy a larger recording into the folder."

    def _is_token(self, text: str | None) -> bool:
        return hmac.compare_digest((text or "").encode(), self._token.encode())

    def _way_to_the_page(self, cookie: str) -> Response:
        """Move the token from the address, where others could read it, into the `cookie`.

        A page leads on: a browser that comes from a file would not send such a cookie along with a redirection.
        """
        value = f"{cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"
        return HTMLResponse(_TO_THE_PAGE, headers={"set-cookie": value, "cache-control": "no-store"})

    async def _forward(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        received, gone = 0, False

        async def receive_limited() -> Message:
            nonlocal received, gone
            message = await receive()
            gone = gone or message["type"] == "http.disconnect"
            received += len(message.get("body", b""))
            if received > self._max_body_bytes:
                raise HTTPException(413, self._too_long)  # it was sent without its length
            return message

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                security_headers = [(key.encode(), value.encode()) for key, value in _HEADERS.items()]
                message = {**message, "headers": [*message.get("headers", []), *security_headers]}
            await send(message)

        try:
            await self._app(scope, receive_limited, send_with_headers)
        except RuntimeError:  # Starlette has no answer for a browser that was closed, which waits for none
            if not gone:
                raise


def _refusal(status: int, reason: str) -> Response:
    return PlainTextResponse(reason, status, {"x-content-type-options": "nosniff"})

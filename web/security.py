"""Access control: only a browser on this machine with the token may use the page.

A page of another site in the same browser sends its own Origin and no cookie. A foreign name that resolves to this
machine (DNS rebinding) is recognised by its Host. The port may be any: over ssh it is that of the other machine.
"""

import hmac
import re
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

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
_TO_THE_PAGE = b'<!doctype html><meta http-equiv="refresh" content="0; url=/">'


class _BodyTooLarge(Exception):
    """The body of a request exceeds the limit."""


class Guard:
    """Pass requests on to `app` if they carry the token, name this host, and come from its own pages."""

    def __init__(self, app: App, token: str, max_body_bytes: int = MAX_BODY_BYTES) -> None:
        self._app, self._token, self._max_body_bytes = app, token, max_body_bytes

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        host = _HOST.fullmatch(headers.get("host", ""))
        if host is None:
            await _send_refusal(scope, send, 421, "Host 127.0.0.1 or localhost with a port expected.")
            return
        refusal, cookie = self._refusal(scope, headers), f"token_{host['port']}"
        if refusal is None and not self._has_valid_cookie(headers.get("cookie", ""), cookie):
            if scope["type"] == "http" and scope["method"] == "GET" and self._has_valid_token(scope):
                await self._set_cookie(send, cookie)
                return
            refusal = 403, "Open the printed address; it contains the token."
        if refusal is not None:
            await _send_refusal(scope, send, *refusal)
        elif scope["type"] == "websocket":
            await self._app(scope, receive, send)
        else:
            await self._forward(scope, receive, send)

    def _refusal(self, scope: MutableMapping[str, Any], headers: dict[str, str]) -> tuple[int, str] | None:
        """Return status and reason of a refusal that does not depend on the token, else None."""
        here = f"http://{headers['host']}"
        origin_required = scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS
        if headers.get("origin", "none" if origin_required else here) != here:
            return 403, "A request from this page expected, another origin found."
        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > self._max_body_bytes:
            return (
                413,
                f"At most {self._max_body_bytes // 2**20} MiB can be sent; copy a larger recording into the folder.",
            )
        return None

    def _has_valid_cookie(self, header: str, name: str) -> bool:
        try:
            cookie = SimpleCookie(header).get(name)
        except CookieError:
            return False
        return cookie is not None and hmac.compare_digest(cookie.value.encode(), self._token.encode())

    def _has_valid_token(self, scope: MutableMapping[str, Any]) -> bool:
        token = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return hmac.compare_digest(token.encode(), self._token.encode())

    async def _set_cookie(self, send: Send, name: str) -> None:
        """Move the token from the address, where others could read it, into the cookie `name`.

        A page leads on: a browser that comes from a file would not send such a cookie along with a redirection.
        """
        cookie = f"{name}={self._token}; Path=/; HttpOnly; SameSite=Strict"
        headers = [(b"content-type", b"text/html"), (b"set-cookie", cookie.encode()), (b"cache-control", b"no-store")]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": _TO_THE_PAGE})

    async def _forward(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        received, started = 0, False

        async def receive_limited() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > self._max_body_bytes:
                raise _BodyTooLarge
            return message

        async def send_with_headers(message: Message) -> None:
            nonlocal started
            if message["type"] == "http.response.start":
                started = True
                security_headers = [(key.encode(), value.encode()) for key, value in _HEADERS.items()]
                message = {**message, "headers": [*message.get("headers", []), *security_headers]}
            await send(message)

        try:
            await self._app(scope, receive_limited, send_with_headers)
        except _BodyTooLarge:
            if not started:
                await _send_refusal(scope, send, 413, "The body is longer than its declared length.")


async def _send_refusal(scope: MutableMapping[str, Any], send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": reason})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"x-content-type-options", b"nosniff")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": reason.encode()})

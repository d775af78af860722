"""Who may talk to the page: only a browser on this machine that was given the token.

A page of another site that the same browser shows can send requests here, but with its own Origin and without the
cookie; a name that was made to point here (DNS rebinding) comes with another Host.
"""

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]

MAX_BODY_BYTES = 256 * 2**20
"""Of an upload. Larger recordings are to be copied into the folder [bytes]."""
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


class _BodyTooLarge(Exception):
    """A request has sent more than is allowed."""


class Guard:
    """Lets requests through to `app` that carry the token, name one of `hosts`, and come from its own pages."""

    def __init__(self, app: App, token: str, port: int, max_body_bytes: int = MAX_BODY_BYTES) -> None:
        self._app, self._token, self._max_body_bytes = app, token, max_body_bytes
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self._cookie = f"token_{port}"

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        refused = self._refusal(scope, headers)
        if refused is None and not self._has_valid_cookie(headers.get("cookie", "")):
            if scope["type"] == "http" and scope["method"] == "GET" and self._has_valid_token(scope):
                await self._set_cookie_and_redirect(scope, send)
                return
            refused = 403, "Open the address that was printed: it holds the token."
        if refused is not None:
            await _send_refusal(scope, send, *refused)
        elif scope["type"] == "websocket":
            await self._app(scope, receive, send)
        else:
            await self._forward(scope, receive, send)

    def _refusal(self, scope: MutableMapping[str, Any], headers: dict[str, str]) -> tuple[int, str] | None:
        """Status and reason, if the request is not from here whoever it is from."""
        if headers.get("host") not in self._hosts:
            return 421, "Another host name expected: 127.0.0.1 or localhost, with the port that was printed."
        origin = headers.get("origin")
        needed = scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS
        if (origin is None and needed) or (origin is not None and origin not in {f"http://{h}" for h in self._hosts}):
            return 403, "A request from this page itself expected, not from another one."
        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > self._max_body_bytes:
            return 413, f"At most {self._max_body_bytes // 2**20} MiB can be sent; copy a larger recording into the folder."
        return None

    def _has_valid_cookie(self, header: str) -> bool:
        try:
            cookie = SimpleCookie(header).get(self._cookie)
        except CookieError:
            return False
        return cookie is not None and hmac.compare_digest(cookie.value.encode(), self._token.encode())

    def _has_valid_token(self, scope: MutableMapping[str, Any]) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return hmac.compare_digest(given.encode(), self._token.encode())

    async def _set_cookie_and_redirect(self, scope: MutableMapping[str, Any], send: Send) -> None:
        """The token moves into a cookie, and out of the address, where others could read it."""
        cookie = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"
        headers = [(b"location", b"/"), (b"set-cookie", cookie.encode()), (b"cache-control", b"no-store")]
        await send({"type": "http.response.start", "status": 303, "headers": headers})
        await send({"type": "http.response.body", "body": b""})

    async def _forward(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        received, started = 0, False

        async def counted() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > self._max_body_bytes:
                raise _BodyTooLarge
            return message

        async def headed(message: Message) -> None:
            nonlocal started
            if message["type"] == "http.response.start":
                started = True
                own = [(key.encode(), value.encode()) for key, value in _HEADERS.items()]
                message = {**message, "headers": [*message.get("headers", []), *own]}
            await send(message)

        try:
            await self._app(scope, counted, headed)
        except _BodyTooLarge:
            if not started:
                await _send_refusal(scope, send, 413, "More was sent than was said.")


async def _send_refusal(scope: MutableMapping[str, Any], send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": reason})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"x-content-type-options", b"nosniff")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": reason.encode()})

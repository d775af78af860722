"""Access control of the page. Requests are passed directly to the application; no server is started."""

import asyncio
from collections.abc import Mapping
from typing import Any

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from delta_web.security import Guard

TOKEN, PORT = "the-token", 8123
HERE = f"http://127.0.0.1:{PORT}"
COOKIE = {"cookie": f"token_{PORT}={TOKEN}"}


async def echo(request: Request) -> PlainTextResponse:
    return PlainTextResponse(f"inside {len(await request.body())}")


async def talk(socket: WebSocket) -> None:
    await socket.accept()
    await socket.close()


ROUTES = [Route("/{path:path}", echo, methods=["GET", "POST"]), WebSocketRoute("/socket", talk)]
GUARDED = Guard(Starlette(routes=ROUTES), TOKEN, max_body_bytes=1000)


def ask(method: str, path: str = "/", headers: Mapping[str, str] | None = None, **options: Any) -> httpx.Response:
    """Send a request and return the response."""

    async def request() -> httpx.Response:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(GUARDED), base_url=HERE) as client:
            return await client.request(method, path, headers=headers, **options)

    return asyncio.run(request())


def first_message(scope: dict[str, Any], headers: Mapping[str, str], received: dict[str, Any]) -> Mapping[str, Any]:
    return messages(scope, headers, received)[0]


def messages(scope: dict[str, Any], headers: Mapping[str, str], received: dict[str, Any]) -> list[Mapping[str, Any]]:
    """Send the raw ASGI message `received`, as often as it is taken, and return those that are sent back."""
    sent: list[Mapping[str, Any]] = []

    async def receive() -> dict[str, Any]:
        return received

    async def send(message: Mapping[str, Any]) -> None:
        sent.append(message)

    raw = [(key.encode(), value.encode()) for key, value in {"host": f"127.0.0.1:{PORT}", **headers}.items()]
    asyncio.run(GUARDED({"path": "/socket", "query_string": b"", "headers": raw, **scope}, receive, send))
    return sent


def test_token_is_moved_from_the_address_into_a_cookie() -> None:
    response = ask("GET", f"/?token={TOKEN}")
    assert response.status_code == 200
    assert "url=/" in response.text
    cookie = response.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert ask("GET", "/", headers=COOKIE).text == "inside 0"


@pytest.mark.parametrize(
    ("method", "path", "headers", "status"),
    [
        *[
            ("GET", path, {"cookie": f"token_{PORT}=wrong"}, 403)
            for path in ("/", "/?token=", "/?token=wrong", "/_nicegui/anything", f"/?token={TOKEN}x")
        ],
        *[
            ("GET", f"/?token={TOKEN}", {**COOKIE, "host": host}, 421)
            for host in ("evil.example", f"evil.example:{PORT}", "127.0.0.1", f"127.0.0.1:{PORT}.evil.example", "")
        ],
        *[
            (method, "/", {**COOKIE, "origin": origin}, 403)
            for method in ("GET", "POST")
            for origin in ("http://evil.example", "null", f"https://127.0.0.1:{PORT}", "http://127.0.0.1:1")
        ],
        ("POST", "/", COOKIE, 403),
        ("POST", "/", {**COOKIE, "origin": HERE}, 200),
        ("POST", "/", {**COOKIE, "origin": f"http://localhost:{PORT}"}, 403),
        ("POST", "/", {**COOKIE, "origin": f"http://localhost:{PORT}", "host": f"localhost:{PORT}"}, 200),
        *[  # over ssh, with another port on the machine of the browser
            ("POST", "/", {"cookie": f"token_9000={TOKEN}", "host": "localhost:9000", "origin": origin}, status)
            for origin, status in (("http://localhost:9000", 200), (HERE, 403), ("http://evil.example:9000", 403))
        ],
    ],
)
def test_only_requests_with_token_host_and_origin_come_through(
    method: str, path: str, headers: dict[str, str], status: int
) -> None:
    response = ask(method, path, headers=headers)
    assert response.status_code == status
    assert ("inside" in response.text) == (status == 200)


@pytest.mark.parametrize(
    "headers",
    [{}, COOKIE, {"origin": HERE}, {**COOKIE, "origin": "http://evil.example"}, {"cookie": "x", "origin": HERE}],
)
def test_websocket_requires_token_and_origin(headers: dict[str, str]) -> None:
    message = first_message({"type": "websocket"}, headers, {})
    assert (message["type"], message["code"]) == ("websocket.close", 1008)


def test_websocket_of_the_page_is_accepted() -> None:
    message = first_message({"type": "websocket"}, {"origin": HERE, **COOKIE}, {"type": "websocket.connect"})
    assert message["type"] == "websocket.accept"


def test_long_upload_is_refused_before_it_is_read() -> None:
    response = ask("POST", "/", headers={**COOKIE, "origin": HERE}, content=b"x" * 1001)
    assert response.status_code == 413
    assert ask("POST", "/", headers={**COOKIE, "origin": HERE}, content=b"x" * 1000).text == "inside 1000"
    for length in ("-1", "many"):
        headers = {**COOKIE, "origin": HERE, "content-length": length}
        assert ask("POST", "/", headers=headers).status_code == 413


def test_upload_without_length_is_cut_off_at_the_limit() -> None:
    """The chunks are counted as they arrive, and never end."""
    received = {"type": "http.request", "body": b"x" * 600, "more_body": True}
    start, body = messages({"type": "http", "method": "POST"}, {"origin": HERE, **COOKIE}, received)
    assert start["status"] == 413
    assert b"At most 0 MiB can be sent" in body["body"]


def test_pages_load_nothing_from_other_hosts() -> None:
    headers = ask("GET", "/", headers=COOKIE).headers
    assert "default-src 'self'" in headers["content-security-policy"]
    assert "http" not in headers["content-security-policy"]
    assert headers["x-frame-options"] == "DENY"
    assert headers["x-content-type-options"] == "nosniff"

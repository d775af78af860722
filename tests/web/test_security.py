"""Who may talk to the page. Nothing here starts a server: requests go straight into the application."""

import asyncio
from collections.abc import Callable, MutableMapping
from typing import Any

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from web.security import Guard

TOKEN, PORT = "the-token", 8123
HERE = f"http://127.0.0.1:{PORT}"
COOKIE = {"cookie": f"token_{PORT}={TOKEN}"}

Ask = Callable[..., httpx.Response]


async def echo(request: Request) -> PlainTextResponse:
    return PlainTextResponse(f"inside {len(await request.body())}")


async def talk(socket: WebSocket) -> None:
    await socket.accept()
    await socket.close()


ROUTES = [Route("/{path:path}", echo, methods=["GET", "POST"]), WebSocketRoute("/socket", talk)]
GUARDED = Guard(Starlette(routes=ROUTES), TOKEN, PORT, max_body_bytes=1000)


@pytest.fixture
def ask() -> Ask:
    """Send one request, and get the answer."""

    def send(method: str, path: str, headers: dict[str, str] | None = None, **more: Any) -> httpx.Response:
        async def sent() -> httpx.Response:
            async with httpx.AsyncClient(transport=httpx.ASGITransport(GUARDED), base_url=HERE) as client:
                return await client.request(method, path, headers=headers, **more)

        return asyncio.run(sent())

    return send


def spoken(app: Any, scope: dict[str, Any], headers: dict[str, str], heard: dict[str, Any]) -> list[Any]:
    """What `app` sends when it is called with raw messages."""
    sent: list[MutableMapping[str, Any]] = []

    async def receive() -> dict[str, Any]:
        return heard

    async def send(message: MutableMapping[str, Any]) -> None:
        sent.append(message)

    given = [(key.encode(), value.encode()) for key, value in headers.items()]
    asyncio.run(app({"path": "/socket", "query_string": b"", "headers": given, **scope}, receive, send))
    return sent


def test_the_token_becomes_a_cookie_and_leaves_the_address(ask: Ask) -> None:
    answer = ask("GET", f"/?token={TOKEN}")
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert ask("GET", "/", headers=COOKIE).text == "inside 0"


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=wrong", "/_nicegui/anything", f"/?token={TOKEN}x"])
def test_without_the_token_nothing_is_shown(path: str, ask: Ask) -> None:
    answer = ask("GET", path, headers={"cookie": f"token_{PORT}=wrong"})
    assert answer.status_code == 403
    assert "inside" not in answer.text
    assert answer.headers["content-type"].startswith("text/plain")


@pytest.mark.parametrize("host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1", f"127.0.0.1:{PORT + 1}", ""])
def test_another_host_name_is_refused_whatever_else_is_right(host: str, ask: Ask) -> None:
    answer = ask("GET", f"/?token={TOKEN}", headers={**COOKIE, "host": host})
    assert answer.status_code == 421


@pytest.mark.parametrize("origin", ["http://evil.example", "null", f"https://127.0.0.1:{PORT}", "http://127.0.0.1:1"])
def test_another_origin_is_refused(origin: str, ask: Ask) -> None:
    assert ask("GET", "/", headers={**COOKIE, "origin": origin}).status_code == 403
    assert ask("POST", "/", headers={**COOKIE, "origin": origin}).status_code == 403


def test_what_changes_something_must_say_where_it_is_from(ask: Ask) -> None:
    assert ask("POST", "/", headers=COOKIE).status_code == 403
    assert ask("POST", "/", headers={**COOKIE, "origin": HERE}).text == "inside 0"
    assert ask("POST", "/", headers={**COOKIE, "origin": f"http://localhost:{PORT}"}).text == "inside 0"


@pytest.mark.parametrize(
    "headers",
    [{}, COOKIE, {"origin": HERE}, {**COOKIE, "origin": "http://evil.example"}, {"cookie": "x", "origin": HERE}],
)
def test_a_websocket_needs_token_and_origin(headers: dict[str, str]) -> None:
    told = spoken(GUARDED, {"type": "websocket"}, {"host": f"127.0.0.1:{PORT}", **headers}, {})
    assert [(one["type"], one["code"]) for one in told] == [("websocket.close", 1008)]


def test_a_websocket_of_the_page_itself() -> None:
    headers = {"host": f"127.0.0.1:{PORT}", "origin": HERE, **COOKIE}
    told = spoken(GUARDED, {"type": "websocket"}, headers, {"type": "websocket.connect"})
    assert told[0]["type"] == "websocket.accept"


def test_a_long_upload_is_refused_before_it_is_read(ask: Ask) -> None:
    answer = ask("POST", "/", headers={**COOKIE, "origin": HERE}, content=b"x" * 1001)
    assert answer.status_code == 413
    assert ask("POST", "/", headers={**COOKIE, "origin": HERE}, content=b"x" * 1000).text == "inside 1000"
    for length in ("-1", "many"):
        headers = {**COOKIE, "origin": HERE, "content-length": length}
        assert ask("POST", "/", headers=headers).status_code == 413


def test_an_upload_that_is_longer_than_it_says_is_cut_off() -> None:
    """Without a length, in pieces: they are counted while they come."""

    async def app(scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
        while (await receive()).get("more_body"):
            pass

    headers = {"host": f"127.0.0.1:{PORT}", "origin": HERE, **COOKIE}
    heard = {"type": "http.request", "body": b"x" * 600, "more_body": True}
    told = spoken(Guard(app, TOKEN, PORT, max_body_bytes=1000), {"type": "http", "method": "POST"}, headers, heard)
    assert told[0]["status"] == 413


def test_pages_may_load_nothing_from_elsewhere(ask: Ask) -> None:
    headers = ask("GET", "/", headers=COOKIE).headers
    assert "default-src 'self'" in headers["content-security-policy"]
    assert "http" not in headers["content-security-policy"]
    assert headers["x-frame-options"] == "DENY"
    assert headers["x-content-type-options"] == "nosniff"

"""Events and assets of the live page, without a server."""

import asyncio
import json
from typing import Any

import httpx
import pytest

from daq.live import page
from daq.live.page import RunBroadcast, application
from delta_web import local
from delta_web.security import Guard

RUN = {"motion": "fig5a", "joints": ["joint_1"]}
DONE = json.dumps({"ended": None})
PORT = 8123


def line(number: int) -> str:
    return json.dumps({"rows": [], "cycles": number})


def received(broadcast: RunBroadcast) -> list[dict[str, Any]]:
    """Events received by a page that opens now and stays until the end."""

    async def look() -> str:
        return "".join([text async for text in broadcast.events()])

    events = asyncio.run(look()).split("\n\n")
    assert events.pop() == ""
    return [json.loads(event.removeprefix("data: ")) for event in events]


def test_page_receives_the_start_the_last_lines_and_the_end_of_the_run() -> None:
    broadcast = RunBroadcast(RUN)
    broadcast.listen(f"{text}\n" for text in [*map(line, range(1000)), DONE])
    first, *lines = received(broadcast)
    assert first["run"] == RUN
    assert [each.get("cycles") for each in lines] == [*range(1000 - page._MAX_LINES + 1, 1000), None]
    assert lines[-1] == {"ended": None}
    assert (broadcast.pages, broadcast.pages_served) == (0, 1)


def test_page_that_is_opened_late_receives_the_warnings_of_before() -> None:
    broadcast = RunBroadcast(RUN)
    early = [{"reports": ["info: bus: found"], "cycles": 0}, {"reports": ["warning: joint_1: slow"], "cycles": 1}]
    broadcast.listen([*map(json.dumps, early), *map(line, range(2, 1000)), DONE])
    _, second, third, *_ = received(broadcast)
    assert second == early[1]
    assert third["cycles"] == 1000 - page._MAX_LINES + 1


def test_run_without_an_end_line_is_shown_as_killed() -> None:
    broadcast = RunBroadcast(RUN)
    broadcast.listen([line(1)])
    assert received(broadcast)[-1] == {"killed": True}


@pytest.mark.parametrize("returned", [True, None])
def test_a_browser_that_is_slower_than_the_run_is_waited_for(returned: bool | None) -> None:
    """Some browsers return from their start only when they are closed: None."""
    broadcast = RunBroadcast(RUN)
    broadcast.listen([*map(line, range(100)), DONE])
    if returned is not None:
        broadcast.browser_expected = returned

    async def late() -> str:
        with local.listen() as listening:
            serving = asyncio.create_task(page.serve(broadcast, "token", listening))
            port = listening.getsockname()[1]
            await asyncio.sleep(1.0)
            async with httpx.AsyncClient(cookies={f"token_{port}": "token"}) as client:
                answer = await client.get(f"http://127.0.0.1:{port}/events", timeout=30)
            await serving
            return answer.text

    shown = asyncio.run(late())
    assert all(f'"cycles": {number}}}' in shown for number in range(100))
    assert DONE in shown


def test_nobody_is_waited_for_where_no_browser_starts() -> None:
    broadcast = RunBroadcast(RUN)
    broadcast.listen([DONE])
    broadcast.browser_expected = False
    with local.listen() as listening:
        asyncio.run(asyncio.wait_for(page.serve(broadcast, "token", listening), 30))


def ask(path: str, **headers: str) -> httpx.Response:
    async def sent() -> httpx.Response:
        broadcast = RunBroadcast(RUN)
        broadcast.listen([DONE])
        guarded = Guard(application(broadcast), "token")
        transport = httpx.ASGITransport(guarded)
        here = httpx.URL(scheme="http", host="localhost", port=PORT)
        async with httpx.AsyncClient(transport=transport, base_url=here) as client:
            return await client.get(path, headers=headers)

    return asyncio.run(sent())


PATHS = {
    "/": "html",
    "/page.js": "javascript",
    "/page.css": "css",
    "/plotly.js": "javascript",
    "/events": "event-stream",
}


@pytest.mark.parametrize("path", PATHS)
def test_every_path_needs_the_token(path: str) -> None:
    assert ask(path).status_code == 403
    answer = ask(path, cookie=f"token_{PORT}=token")
    assert answer.status_code == 200
    assert PATHS[path] in answer.headers["content-type"]
    assert "default-src 'self'" in answer.headers["content-security-policy"]
    assert ask(path, cookie=f"token_{PORT}=token", origin="http://elsewhere").status_code == 403


def test_page_loads_nothing_from_other_hosts() -> None:
    for path in ("/", "/page.js", "/page.css"):
        assert "//" not in ask(path, cookie=f"token_{PORT}=token").text.replace("// ", "")

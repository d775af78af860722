"""Start of the viewers of a run, with their first line."""

import importlib.util
import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from daq.cycle.session import RunRequest
from daq.live.status import LineSink
from daq.live.viewer import Viewer
from delta_web import local
from recordings.errors import BadInput


@contextmanager
def viewers(
    request: RunRequest, page: bool, foxglove: int | None, say: Callable[[str], None]
) -> Iterator[list[LineSink]]:
    """Show the run of `request`: on a page in the browser, and over the Foxglove WebSocket on the port `foxglove`.

    Yields the sinks for the status lines. `say` gets the addresses.

    Raises:
        BadInput: the port is taken, or the package for Foxglove is missing.
    """
    with ExitStack() as stack:
        started_viewers = []
        if foxglove is not None:
            started_viewers.append(stack.enter_context(_foxglove(request, foxglove, say)))
            say(f"foxglove: ws://{local.HOST}:{foxglove}")
        if page:
            viewer, address = _page(request, say)
            started_viewers.append(stack.enter_context(viewer))
            say(f"live view: {address}")
        yield [viewer.send for viewer in started_viewers]


def _page(request: RunRequest, say: Callable[[str], None]) -> tuple[Viewer, str]:
    token = secrets.token_urlsafe(24)
    with local.listen() as listening:
        first = {
            "listening": listening.fileno(),
            "token": token,
            "folder": str(request.out.parent.resolve()),
            "run": _run(request),
        }
        return Viewer("daq.live.page", first, [listening.fileno()], say), local.address(listening, token)


def _foxglove(request: RunRequest, port: int, say: Callable[[str], None]) -> Viewer:
    if importlib.util.find_spec("foxglove") is None:
        raise BadInput(
            "--foxglove needs the package foxglove-sdk, which is not installed; install it with "
            "`pip install 'delta-workbench[foxglove]'`, or use --live"
        )
    local.listen(port).close()
    first = {"port": port, "run": _run(request), "rig": request.rig.model_dump_json()}
    return Viewer("daq.live.foxglove", first, say=say)


def _run(request: RunRequest) -> dict[str, Any]:
    return {
        "rig": request.rig.name,
        "joints": request.rig.joint_names,
        "motion": request.trajectory.name,
        "out": request.out.name,
        "simulated": request.seed is not None,
        "start_ns": time.time_ns(),
    }

"""Live view over the Foxglove WebSocket, for Foxglove and other programs with its protocol.

The topics /joint_states and /joint_commands are those of a recording, so that one layout serves both; /live and /run
are JSON. The server is a process of its own (`python -m daq.live.foxglove`), fed by `daq.live.viewer`.
"""

import json
import math
import os
import sys
from typing import Any

import foxglove

from recordings import schemas
from recordings.writer import joint_state_encoder
from web.local import HOST

_NUMBERS = {"type": "array", "items": {"type": ["number", "null"]}}
_QUANTITIES = ("following_error", "voltage")
_LIVE = {"type": "object", "properties": dict.fromkeys(_QUANTITIES, _NUMBERS)}
_FIGURES = ("done", "total", "cycles", "answers_lost", "cycles_missed", "following_error_max", "lateness")
_RUN = {
    "type": "object",
    "properties": {"status": {"type": "string"}} | {name: {"type": "number"} for name in _FIGURES},
}


class Publisher:
    """Publisher of the status lines of a run to all connected clients."""

    def __init__(self, run: dict[str, Any]) -> None:
        self._start: int = run["start_ns"]
        self._encoder = joint_state_encoder(tuple(run["joints"]))
        self._states, self._commands = (_joint_channel(topic) for topic in ("/joint_states", "/joint_commands"))
        self._live = foxglove.Channel("/live", schema=_LIVE | {"title": "live"})
        self._run = foxglove.Channel("/run", schema=_RUN | {"title": "run"})

    def publish(self, status: dict[str, Any]) -> None:
        """Publish the rows of a status line, each at its SYNC instant, and its figures."""
        for row in status["rows"]:
            stamp = self._start + round(1e9 * row["time"])
            for channel, values in ((self._states, row["position"]), (self._commands, row["command"])):
                numbers = [math.nan if value is None else value for value in values]
                channel.log(self._encoder.pack([*divmod(stamp, 10**9), *numbers]), log_time=stamp)
            self._live.log({name: row[name] for name in _QUANTITIES}, log_time=stamp)
        if status["rows"]:
            self._run.log({name: status[name] for name in ("status", *_FIGURES)}, log_time=stamp)


def _joint_channel(topic: str) -> foxglove.Channel:
    name, text = schemas.TOPICS[topic]
    schema = foxglove.Schema(name=name, encoding="ros2msg", data=text.encode())
    return foxglove.Channel(topic, schema=schema, message_encoding="cdr")


def main() -> None:
    """Publish the status lines on stdin."""
    os.nice(5)  # the cycle comes first
    first = json.loads(sys.stdin.readline())
    publisher = Publisher(first["run"])
    # No capabilities: clients are read-only.
    server = foxglove.start_server(name="delta-workbench", host=HOST, port=first["port"])
    for line in sys.stdin:
        if "rows" in (status := json.loads(line)):
            publisher.publish(status)
    server.stop()


if __name__ == "__main__":
    main()

"""Live view over the Foxglove WebSocket, for Foxglove and other programs with its protocol.

The topics /joint_states, /joint_commands, /robot_description and /tf_static are those of a recording, so that one
layout serves both; /tf moves the robot. JSON: /live and /run, and /watch and /alarm of a run that is watched. The
server is a process of its own (`python -m daq.live.foxglove`), fed by `daq.live.viewer`.
"""

import contextlib
import json
import math
import os
import sys
from typing import Any

import foxglove
import numpy as np

from delta_web.local import HOST
from recordings import schemas
from recordings.description import description_messages
from recordings.rig import Rig
from recordings.writer import joint_state_encoder
from trajectories.kinematics import Unreachable
from trajectories.transforms import Transforms

_NUMBERS = {"type": "array", "items": {"type": ["number", "null"]}}
_QUANTITIES = ("following_error", "voltage")
_LIVE = {"type": "object", "properties": dict.fromkeys(_QUANTITIES, _NUMBERS)}
_FIGURES = ("done", "total", "cycles", "answers_lost", "cycles_missed", "following_error_max", "lateness")
_RUN = {
    "type": "object",
    "properties": {"status": {"type": "string"}, "reports": {"type": "array", "items": {"type": "string"}}}
    | {name: {"type": "number"} for name in _FIGURES},
}


_SAMPLED = ("measured", "model", "residual")
_WATCH = {
    "type": "object",
    "properties": dict.fromkeys((*_SAMPLED, "floor"), _NUMBERS)
    | {"terms": {"type": "object", "additionalProperties": _NUMBERS}},
}
_ALARM = {"type": "object", "properties": {"effect": {"type": ["string", "null"]}, "joints": _NUMBERS}}


_DESCRIBED = 1_000_000_000
"""Interval at which the robot is described anew [ns]: a client that comes late has not heard it."""


class Publisher:
    """Publisher of the status lines of a run to all connected clients."""

    def __init__(self, run: dict[str, Any], rig: Rig) -> None:
        self._start: int = run["start_ns"]
        self._encoder = joint_state_encoder(tuple(run["joints"]))
        self._states, self._commands = (
            _channel(topic, schemas.TOPICS[topic]) for topic in ("/joint_states", "/joint_commands")
        )
        self._description = [
            (_channel(topic, schemas.DESCRIPTION_TOPICS[topic]), message)
            for topic, message in description_messages(rig).items()
        ]
        self._described = -_DESCRIBED
        self._transforms = Transforms(rig)
        self._tf = _channel("/tf", schemas.TF_MESSAGE)
        self._live = foxglove.Channel("/live", schema=_LIVE | {"title": "live"})
        self._run = foxglove.Channel("/run", schema=_RUN | {"title": "run"})

        self._watch = foxglove.Channel("/watch", schema=_WATCH | {"title": "watch"})
        self._alarm = foxglove.Channel("/alarm", schema=_ALARM | {"title": "alarm"})

    def publish_watch(self, line: dict[str, Any]) -> None:
        """Publish a line of the watch: its samples, each at its instant, or its alarm."""
        stamp = self._start + round(1e9 * line["time"])
        if line["alarm"]:
            self._alarm.log(line["alarm"], log_time=stamp)
        samples = line.get("samples", {"time": []})
        for number, time in enumerate(samples["time"]):
            values: dict[str, Any] = {name: samples[name][number] for name in _SAMPLED}
            values["floor"] = line["floor_rms"]
            values["terms"] = {name: rows[number] for name, rows in samples["terms"].items()}
            self._watch.log(values, log_time=self._start + round(1e9 * time))

    def publish(self, status: dict[str, Any]) -> None:
        """Publish the rows of a status line, each at its SYNC instant, and its figures."""
        for row in status["rows"]:
            stamp = self._start + round(1e9 * row["time"])
            for channel, values in ((self._states, row["position"]), (self._commands, row["command"])):
                numbers = [math.nan if value is None else value for value in values]
                channel.log(self._encoder.pack([*divmod(stamp, 10**9), *numbers]), log_time=stamp)
            self._live.log({name: row[name] for name in _QUANTITIES}, log_time=stamp)
        if status["rows"]:
            self._publish_pose(stamp, status["rows"][-1]["position"])
            self._run.log({name: status[name] for name in ("status", "reports", *_FIGURES)}, log_time=stamp)

    def _publish_pose(self, stamp: int, position: list[float | None]) -> None:
        """Publish where the links are, and now and then what they are."""
        if stamp - self._described >= _DESCRIBED:
            self._described = stamp
            for channel, message in self._description:
                channel.log(message, log_time=stamp)
        with contextlib.suppress(Unreachable):  # a wrong angle is shown by the plots
            for when, message in self._transforms.messages([stamp], np.array([position], float)):
                self._tf.log(message, log_time=when)


def _channel(topic: str, message_type: tuple[str, str]) -> foxglove.Channel:
    schema = foxglove.Schema(name=message_type[0], encoding="ros2msg", data=message_type[1].encode())
    return foxglove.Channel(topic, schema=schema, message_encoding="cdr")


def main() -> None:
    """Publish the status lines on stdin."""
    os.nice(5)  # the cycle comes first
    first = json.loads(sys.stdin.readline())
    publisher = Publisher(first["run"], Rig.model_validate_json(first["rig"]))
    # No capabilities: clients are read-only.
    server = foxglove.start_server(name="delta-workbench", host=HOST, port=first["port"])
    for line in sys.stdin:
        said = json.loads(line)
        if "rows" in said:
            publisher.publish(said)
        elif "watch" in said:
            publisher.publish_watch(said["watch"])
    server.stop()


if __name__ == "__main__":
    main()

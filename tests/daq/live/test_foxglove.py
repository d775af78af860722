"""Live view over the Foxglove WebSocket, received by an independent client of the protocol."""

import json
import socket
import struct
import subprocess
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from websockets.sync.client import ClientConnection, connect

from recordings import schemas
from recordings.cdr import Layout, parse_schema
from recordings.reader import read
from tests.conftest import Runner, launcher
from tests.patience import patient
from tests.running import free_port

Messages = dict[str, list[tuple[int, bytes]]]
"""Log times [ns] and payloads of each topic."""


def connected(port: int, patience: float = 120.0) -> ClientConnection:
    until = time.monotonic() + patient(patience)
    while True:
        try:
            return connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], max_size=None)  # type: ignore[list-item]
        except OSError:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)


def listen(client: ClientConnection) -> Messages:
    """Subscribe to all channels and receive messages until the server closes."""
    received: Messages = defaultdict(list)
    topics: dict[int, str] = {}
    for message in client:
        if isinstance(message, str):
            said = json.loads(message)
            for channel in said.get("channels", []) if said["op"] == "advertise" else []:
                topics[channel["id"]] = channel["topic"]
                wanted = {"op": "subscribe", "subscriptions": [{"id": channel["id"], "channelId": channel["id"]}]}
                client.send(json.dumps(wanted))
        elif message[0] == 1:  # MessageData: subscription, log time, payload
            subscription, stamp = struct.unpack_from("<IQ", message, 1)
            received[topics[subscription]].append((stamp, message[13:]))
    return received


def positions(messages: list[tuple[int, bytes]]) -> np.ndarray:
    """Log time [ns] and positions of JointState messages, (n, 1 + dof)."""
    fields = parse_schema(schemas.JOINT_STATE)
    layout = Layout.of(fields, messages[0][1])
    values = np.frombuffer(b"".join(payload for _, payload in messages), layout.dtype)
    assert layout.fits(values).all()
    stamps = [stamp for stamp, _ in messages]
    header = values["header.stamp"]
    assert (header["sec"].astype(np.int64) * 10**9 + header["nanosec"].astype(np.int64)).tolist() == stamps
    return np.column_stack([stamps, values["position"]])


@pytest.mark.slow
def test_client_receives_the_recorded_values(tmp_path: Path) -> None:
    pytest.importorskip("foxglove")
    port = free_port(socket.SOCK_STREAM)
    command = ["record", "--traj", "fig5a", "--cycles", "20", "--rate", "100", "--out", "a.mcap"]
    with subprocess.Popen([*launcher("daq"), *command, "--foxglove", str(port)], cwd=tmp_path) as process:
        with connected(port) as client:
            received = listen(client)
        assert process.wait(patient(120)) == 0
    moving = {"/robot_description", "/tf_static", "/tf"}
    assert set(received) == {"/joint_states", "/joint_commands", "/live", "/run"} | moving
    assert len(received["/tf"]) > 20
    assert received["/robot_description"][0][1][8:15] == b"<robot "
    recording = read(tmp_path / "a.mcap")
    states, commands = positions(received["/joint_states"]), positions(received["/joint_commands"])
    # The client subscribes to one after the other, and a client that is slow misses messages of either.
    common = np.intersect1d(states[:, 0], commands[:, 0])
    states, commands = (table[np.isin(table[:, 0], common)] for table in (states, commands))
    assert len(common) > 300
    rows = np.round((states[:, 0] - states[0, 0]) / 1e7).astype(int)
    # The client joins somewhere in the run; the stamps locate all its messages relative to the first one.
    firsts = range(len(recording.position) - rows[-1])
    [first] = [row for row in firsts if _same(recording.position[row + rows], states[:, 1:])]
    assert commands[:, 0].tolist() == states[:, 0].tolist()
    assert _same(recording.command[first + rows], commands[:, 1:])
    live = [json.loads(payload) for _, payload in received["/live"]]
    errors = [item["following_error"][0] for item in live if item["following_error"][0] is not None]
    worst = max(json.loads(payload)["following_error_max"] for _, payload in received["/run"])
    assert 0 < max(map(abs, errors)) <= worst + 1e-9


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return np.allclose(a, b, rtol=0, atol=2e-9, equal_nan=True)


def test_missing_package_and_occupied_port_are_reported_before_the_run_starts(
    daq_in_process: Runner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("foxglove")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = daq_in_process("record", "--traj", "fig5a", "--hidden", 3, "--foxglove", port)
    assert (done.code, str(port) in done.err) == (2, True)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    done = daq_in_process("record", "--traj", "fig5a", "--foxglove")
    assert done.code == 2
    assert "pip install 'delta-workbench[foxglove]'" in done.err
    assert not list(tmp_path.iterdir())

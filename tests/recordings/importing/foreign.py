"""Files of other programs, made from a recording with other people's libraries.

`python -m tests.recordings.importing.foreign FOLDER` writes `recordings/samples/foreign`, with hidden cogging.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from mcap_ros2.writer import Writer as McapWriter
from pyarrow import parquet
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

from ident.dynamics.torque_map import torque_from_voltage
from recordings import schemas
from recordings.reader import read
from recordings.recording import Recording

START_NS = 1_767_600_000_000_000_000
"""2026-01-05 08:00:00 UTC."""
START = "2026-01-05T08:00:00.000+00:00"
NAMES = ("left", "right", "rear")
KT = 0.35
"""Torque per ampere of the scope's drives [N m/A]."""


def torque(recording: Recording) -> np.ndarray:
    """Torque (n, dof) [N m] of the recorded voltages."""
    return torque_from_voltage(recording.voltage, recording.rig.torque)


def stamps(recording: Recording) -> np.ndarray:
    return START_NS + np.rint(recording.time * 1e9).astype(np.int64)


def ros2_folder(recording: Recording, folder: Path, storage: StoragePlugin = StoragePlugin.MCAP) -> Path:
    path = folder / f"rosbag2_{storage.name.lower()}"
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(path, version=9, storage_plugin=storage) as writer:
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        writer.add_connection("/robot_description", "std_msgs/msg/String", typestore=store)
        for stamp, message in _messages(recording, store.types):
            writer.write(connection, stamp + 250_000, store.serialize_cdr(message, message.__msgtype__))
    return path


def db3(recording: Recording, folder: Path) -> Path:
    path = folder / "joint_states.db3"
    next(ros2_folder(recording, folder, StoragePlugin.SQLITE3).glob("*.db3")).rename(path)
    return path


def _messages(recording: Recording, types: Any) -> Iterator[tuple[int, Any]]:
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    effort = torque(recording)
    for k, stamp in enumerate(stamps(recording).tolist()):
        yield (
            stamp,
            types["sensor_msgs/msg/JointState"](
                header=header(stamp=time(*divmod(stamp, 10**9)), frame_id="base"),
                name=list(NAMES),
                position=recording.position[k],
                velocity=np.zeros(0),
                effort=effort[k],
            ),
        )


def mcap(recording: Recording, folder: Path) -> Path:
    """A bare MCAP file, whose joints are in another order."""
    path = folder / "joint_states_0.mcap"
    effort, order = torque(recording), [2, 0, 1]
    with path.open("wb") as stream, McapWriter(stream) as writer:
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", schemas.JOINT_STATE)
        for k, stamp in enumerate(stamps(recording).tolist()):
            message = {
                "header": {"stamp": dict(zip(("sec", "nanosec"), divmod(stamp, 10**9), strict=True)), "frame_id": ""},
                "name": [NAMES[i] for i in order],
                "position": recording.position[k][order].tolist(),
                "velocity": [],
                "effort": effort[k][order].tolist(),
            }
            writer.write_message("/arm/joint_states", schema, message, stamp, stamp)
    return path


def scope_csv(recording: Recording, folder: Path) -> Path:
    """Semicolons, decimal commas, a comment, a preamble, and deg, ms, A."""
    path = folder / "scope.csv"
    angle, current = np.rad2deg(recording.position), torque(recording) / KT
    head = "Drive scope V3.2;;;;;;\n# recorded by the commissioning tool\nTime [ms];" + ";".join(
        [*(f"Actual position A{k} [deg]" for k in (1, 2, 3)), *(f"Iq A{k} [A]" for k in (1, 2, 3))]
    )
    rows = np.column_stack([recording.time * 1e3, angle, current])
    body = "\n".join(";".join(f"{x:.9g}".replace(".", ",") for x in row) for row in rows.tolist())
    path.write_text(f"{head}\n{body}\n", encoding="utf-8")
    return path


def mat(recording: Recording, folder: Path) -> Path:
    path = folder / "log.mat"
    log = {"t": recording.time, "q": recording.position, "tau": torque(recording).T, "comment": "arm 2"}
    savemat(path, {"log": log, "Ts": 0.004})
    return path


def parquet_file(recording: Recording, folder: Path) -> Path:
    path = folder / "log.parquet"
    columns = {"timestamp": pyarrow.array(stamps(recording), pyarrow.timestamp("ns", "UTC"))}
    columns |= {f"q{k}_deg": pyarrow.array(np.rad2deg(column)) for k, column in enumerate(recording.position.T)}
    columns |= {f"torque{k}_mNm": pyarrow.array(column * 1e3) for k, column in enumerate(torque(recording).T)}
    parquet.write_table(pyarrow.table(columns), path)
    return path


FILES: dict[str, tuple[Callable[[Recording, Path], Path], list[str]]] = {
    "rosbag2 folder": (ros2_folder, []),
    "bare MCAP": (mcap, ["--names", "left,right,rear"]),
    "db3": (db3, []),
    "scope CSV": (scope_csv, ["--kt", str(KT)]),
    "MAT": (mat, []),
    "Parquet": (parquet_file, []),
}
"""How each is made, and the options that the file cannot say."""


def write_samples(folder: Path) -> None:
    """Write the two motions of the samples, of a simulated rig with hidden cogging, as files of other programs."""
    for trajectory in ("fig5a", "fig5b"):
        with tempfile.TemporaryDirectory() as scratch:
            file = Path(scratch) / "rig.mcap"
            options = f"--traj {trajectory} --cycles 2 --rate 250 --hidden 9 --out {file}".split()
            subprocess.run([Path(sys.executable).with_name("daq"), "record", *options], check=True)
            scope_csv(read(file), folder).rename(folder / f"scope-{trajectory}.csv")
            if trajectory == "fig5a":
                mcap(read(file), folder)


if __name__ == "__main__":
    write_samples(Path(sys.argv[1]))

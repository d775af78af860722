"""The process that computes a model's torque, played by short programs."""

import hashlib
import json
import signal
import subprocess
import sys
from pathlib import Path
from threading import Timer

import numpy as np
import pytest

from daq.feedforward import source as sources
from daq.feedforward.source import PlannedTorque, open_source
from recordings.errors import BadInput
from recordings.rig import load_rig, simulated_rig
from tests.daq.feedforward.given import write_nominal_torque
from trajectories import load
from trajectories.checks import torque_estimate

RIG = simulated_rig().at_rate(100.0).with_torque_offset()
TRAJECTORY = load("fig5b", RIG, cycles=1)
APPROACH = np.tile(TRAJECTORY.joint_position[0], (5, 1))

# Arguments: torque MODEL --csv STREAM --rig RIG -o TABLE. Each torque is 10 times the position.
GOOD = """
import csv, sys
rows = list(csv.DictReader(open(sys.argv[4])))
with open(sys.argv[8], "w") as out:
    print(",".join([*rows[0], "torque_1", "torque_2", "torque_3"]), file=out)
    for row in rows:
        print(",".join([*row.values(), *(str(10 * float(row[f"position_{j}"])) for j in (1, 2, 3))]), file=out)
"""
REFUSING = "import sys; print('warning: x', file=sys.stderr); sys.exit('error: the rig of the model expected')"
LASTING = "import time; time.sleep(60)"


def model(folder: Path) -> Path:
    path = folder / "m.json"
    path.write_text(json.dumps({"schema": 1}))
    return path


def run(monkeypatch: pytest.MonkeyPatch, folder: Path, program: str) -> PlannedTorque:
    monkeypatch.setattr(sources, "_IDENT", [sys.executable, "-c", program])
    return open_source(model(folder), RIG, None, TRAJECTORY).compute(1.5, APPROACH, TRAJECTORY)


def test_torque_of_every_streamed_sample_is_computed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    planned = run(monkeypatch, tmp_path, GOOD)
    np.testing.assert_allclose(planned.approach, 10 * APPROACH)
    np.testing.assert_allclose(planned.stream, 10 * TRAJECTORY.joint_position)
    source = open_source(tmp_path / "m.json", RIG, None, TRAJECTORY)
    assert source.digest == hashlib.sha256((tmp_path / "m.json").read_bytes()).hexdigest()
    assert len(planned.table_digest) == 64


def test_what_ident_refuses_is_refused_before_the_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sources, "_IDENT", [sys.executable, "-c", REFUSING])
    with pytest.raises(BadInput, match=r"--feedforward .*m.json: the rig of the model expected"):
        open_source(model(tmp_path), RIG, None, TRAJECTORY)


def test_interrupt_ends_the_trial(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sources, "_IDENT", [sys.executable, "-c", LASTING])
    processes = []

    class Interrupted(subprocess.Popen[bytes]):
        def wait(self, timeout: float | None = None) -> int:
            if not processes:
                processes.append(self)
                raise KeyboardInterrupt
            return super().wait(timeout)

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        open_source(model(tmp_path), RIG, None, TRAJECTORY)
    (process,) = processes
    assert process.wait(10.0) == -signal.SIGKILL


@pytest.mark.parametrize("delay", [0.0, 0.5])
def test_process_is_ended_with_the_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, delay: float) -> None:
    monkeypatch.setattr(sources, "_IDENT", [sys.executable, "-c", GOOD])
    source = open_source(model(tmp_path), RIG, None, TRAJECTORY)
    monkeypatch.setattr(sources, "_IDENT", [sys.executable, "-c", LASTING])
    Timer(delay, source.cancel).start()
    with pytest.raises(BadInput, match="ended without a reason"):
        source.compute(1.5, APPROACH, TRAJECTORY)


def test_rig_of_the_process_is_the_simulated_one_without_a_rig_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    copy = "import shutil, sys; shutil.copy(sys.argv[6], {!r}); sys.exit('error: seen')"
    with pytest.raises(BadInput, match="seen"):
        run(monkeypatch, tmp_path, copy.format(str(tmp_path / "rig.toml")))
    rig = load_rig(tmp_path / "rig.toml", driven=False)
    assert (rig.geometry, rig.torque) == (RIG.geometry, RIG.torque)


def test_table_is_taken_as_it_is_and_leaves_the_approach_alone(tmp_path: Path) -> None:
    path, torque = tmp_path / "t.csv", torque_estimate(TRAJECTORY, RIG)
    write_nominal_torque(path, TRAJECTORY, RIG)
    source = open_source(path, RIG, None, TRAJECTORY)
    planned = source.compute(0.0, APPROACH, TRAJECTORY)
    assert planned.approach is None
    np.testing.assert_allclose(planned.stream, torque, atol=1e-9)
    assert source.digest == planned.table_digest


@pytest.mark.parametrize(("content", "message"), [(None, "cannot be read"), ("no JSON", "a model file")])
def test_file_that_is_neither_is_refused(tmp_path: Path, content: str | None, message: str) -> None:
    path = tmp_path / "m.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(BadInput, match=message):
        open_source(path, RIG, None, TRAJECTORY)

"""The process that computes a model's torque, played by short programs."""

import hashlib
import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from threading import Timer

import numpy as np
import pytest

from daq.feedforward import source as sources
from daq.feedforward.source import open_source
from recordings.errors import BadInput
from recordings.rig import load_rig, simulated_rig
from tests.daq.feedforward.given import write_nominal_torque
from tests.patience import patient
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


Program = Callable[[str], Path]


@pytest.fixture
def model(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Program:
    """Set the program that is run in the place of `ident`; a model for it."""

    def played(program: str) -> Path:
        monkeypatch.setattr(sources, "IDENT", [sys.executable, "-c", program])
        (tmp_path / "m.json").write_text(json.dumps({"schema": 1}))
        return tmp_path / "m.json"

    return played


def test_torque_of_every_streamed_sample_is_computed(model: Program) -> None:
    source = open_source(model(GOOD), RIG, None, TRAJECTORY)
    planned = source.compute(1.5, APPROACH, TRAJECTORY)
    np.testing.assert_allclose(planned.approach, 10 * APPROACH)
    np.testing.assert_allclose(planned.stream, 10 * TRAJECTORY.joint_position)
    assert source.digest == hashlib.sha256(source.path.read_bytes()).hexdigest()
    assert len(planned.table_digest) == 64


def test_what_ident_refuses_is_refused_before_the_run(model: Program) -> None:
    with pytest.raises(BadInput, match=r"--feedforward .*m.json: the rig of the model expected"):
        open_source(model(REFUSING), RIG, None, TRAJECTORY)


def test_interrupt_ends_the_trial(model: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    processes = []

    class Interrupted(subprocess.Popen[bytes]):
        def wait(self, timeout: float | None = None) -> int:
            if not processes:
                processes.append(self)
                raise KeyboardInterrupt
            return super().wait(timeout)

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        open_source(model(LASTING), RIG, None, TRAJECTORY)
    (process,) = processes
    assert process.wait(patient(10.0)) == -signal.SIGKILL


@pytest.mark.parametrize("delay", [0.0, 0.5])
def test_process_is_ended_with_the_run(model: Program, delay: float) -> None:
    source = open_source(model(GOOD), RIG, None, TRAJECTORY)
    model(LASTING)
    Timer(delay, source.cancel).start()
    with pytest.raises(BadInput, match="ended without a reason"):
        source.compute(1.5, APPROACH, TRAJECTORY)


def test_rig_of_the_process_is_the_simulated_one_without_a_rig_file(model: Program, tmp_path: Path) -> None:
    copy = "import shutil, sys; shutil.copy(sys.argv[6], {!r}); sys.exit('error: seen')"
    with pytest.raises(BadInput, match="seen"):
        open_source(model(copy.format(str(tmp_path / "rig.toml"))), RIG, None, TRAJECTORY)
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


def test_file_that_is_neither_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="does not exist"):
        open_source(tmp_path / "m.json", RIG, None, TRAJECTORY)
    (tmp_path / "m.json").write_text("no JSON")
    with pytest.raises(BadInput, match="a model file"):
        open_source(tmp_path / "m.json", RIG, None, TRAJECTORY)

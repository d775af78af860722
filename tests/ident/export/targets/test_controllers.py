"""The examples for controllers compile, and command the torque of the model; stand-ins take the place of ROS 2."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.documents import ROOT
from tests.ident.export.models import model_with
from tests.ident.export.targets.compilers import compile_c, need
from tests.ident.export.targets.test_c import DT, export, states

EXAMPLES = ROOT / "docs" / "examples"
ROS = Path(__file__).parent / "ros2"
KP, KD = 10.0, 0.5
MODEL = model_with(["rod_inertia", "stribeck"])


@pytest.fixture(scope="module")
def code(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export(MODEL, tmp_path_factory.mktemp("code"))


def test_ros2_control_commands_the_models_torque_and_a_pd(code: Path) -> None:
    need("g++")
    library = compile_c("gcc", [code / "delta_model.c"], code / "delta_model.o", "-c")
    program = code / "controller"
    folders = [f"-I{folder}" for folder in (ROS, code, EXAMPLES / "ros2_control")]
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    words = ["g++", "-std=c++17", "-O1", *warnings, *folders, str(ROS / "main.cpp"), str(library), "-o", str(program)]
    built = subprocess.run(words, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr

    q, qd, qdd = (signal[:20] for signal in states())
    q[-1, 0] = -3.0  # out of reach
    measured = [q - 0.01, qd + 0.1]
    lines = np.hstack([q, qd, qdd, *measured])
    text = "\n".join(" ".join(map(repr, line)) for line in lines.tolist())
    done = subprocess.run([program], input=text, capture_output=True, text=True)
    well, *effort = np.array([line.split() for line in done.stdout.splitlines()], float).T
    expected = MODEL.torque(q[:-1], qd[:-1], qdd[:-1], DT) + (KP * (q - measured[0]) + KD * (qd - measured[1]))[:-1]
    assert well.tolist() == [1.0] * 19 + [0.0]
    np.testing.assert_allclose(np.transpose(effort)[:-1], expected, rtol=1e-9)
    assert not np.transpose(effort)[-1].any()


def test_block_of_simulink_gives_the_models_torque(code: Path) -> None:
    folder = EXAMPLES / "simulink"
    options = ("-shared", "-fPIC", f"-I{code}", f"-I{folder}")
    shared = compile_c("gcc", [folder / "model_block.c", code / "delta_model.c"], code / "block.so", *options)
    block = ctypes.CDLL(str(shared))
    block.model_block_start()
    q, qd, qdd = (signal[:5] for signal in states())
    q[-1, 0] = -3.0  # out of reach
    tau = (ctypes.c_double * 3)()
    found = []
    for row in zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True):
        block.model_block(*((ctypes.c_double * 3)(*values) for values in row), ctypes.c_double(DT), tau)
        found.append(list(tau))
    np.testing.assert_allclose(found[:-1], MODEL.torque(q[:-1], qd[:-1], qdd[:-1], DT), rtol=1e-9)
    assert found[-1] == [0.0, 0.0, 0.0]

"""Fit and compare of an imported prismatic axis with uneven sampling."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ident.program import program
from recordings.imported import imported_rig, measured_torque
from recordings.rig import Torque
from recordings.writer import RecordingWriter
from tests.made_up import run_of
from tests.running import ran

MASS, VISCOUS, COULOMB, OFFSET = 3.0, 4.0, 1.5, 0.7


def write(path: Path, seed: int, voltage: bool = False) -> Path:
    """A recording of a slide whose force follows Newton's law, friction and a constant; steps of 1.6 to 2.4 ms."""
    rng = np.random.default_rng(seed)
    t = np.arange(6000) * 2e-3 + rng.uniform(-2e-4, 2e-4, 6000)
    omega, phase = np.array([2.0, 5.0, 9.0]), rng.uniform(0, 6, 3)
    angle = np.outer(t, omega) + phase
    x, v = 0.1 * np.sin(angle).sum(axis=1), 0.1 * (omega * np.cos(angle)).sum(axis=1)
    a = -0.1 * (omega**2 * np.sin(angle)).sum(axis=1)
    force = MASS * a + VISCOUS * v + COULOMB * np.sign(v) + OFFSET + rng.normal(0, 0.05, t.shape)
    rig = imported_rig(
        "slide", 1, 500.0, joints=("prismatic",), torque=Torque(map="linear") if voltage else measured_torque(1)
    )
    run = run_of(trajectory="imported", trajectory_digest="", cycles=0, simulated=False, pace="realtime")
    with RecordingWriter(path, rig, run) as writer:
        for k, stamp in enumerate(np.rint((t - t[0]) * 1e9).astype(np.int64).tolist()):
            writer.joint_states(stamp, stamp, x[k : k + 1], None, None if voltage else force[k : k + 1])
            writer.amplifiers(stamp, stamp, k, -1, 0.0, [force[k] if voltage else np.nan], [0], [0])
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("slide")
    write(folder / "a.mcap", 0)
    write(folder / "b.mcap", 1)
    return folder


run = partial(ran, program)


def test_fit_and_compare(folder: Path) -> None:
    options = ("--with", "torque_offset", "--method", "ls", "--details")
    fitted = run("fit", folder / "a.mcap", "--validate", folder / "b.mcap", *options)
    for text in ("kg", "N s/m", "RMS [N]", "torque_offset.a1", "torque was measured"):
        assert text in fitted.stdout
    for text in ("Eq. (26)", "as in (36)", "L2", "RELATIVE", "Table 1"):
        assert text not in fitted.stdout
    model = json.loads((folder / "a.model.json").read_text())
    values = [parameter["value"] for parameter in model["parameters"]]
    np.testing.assert_allclose(values, [MASS, VISCOUS, COULOMB, OFFSET], rtol=0.02)
    assert model["validate"]["fitted"]["rms"][0] < 0.03
    compared = run("compare", folder / "a.model.json", folder / "b.mcap", "--json")
    joint = json.loads(compared.stdout)["joints"][0]
    assert joint["unit"] == "N"
    assert joint["curves"]["velocity"]["unit"] == "m/s"
    assert joint["noise_rms"] < 0.05
    # Without the offset the model is worse.
    result = run("fit", folder / "a.mcap", "--method", "ls", "-o", folder / "base.json", "--json")
    assert json.loads(result.stdout)["train"]["fitted"]["rms"][0] > 0.3

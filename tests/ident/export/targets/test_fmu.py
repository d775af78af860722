"""FMPy accepts the FMU, and simulates what Python computes."""

from pathlib import Path

import numpy as np
import pytest

from ident.export import paths
from ident.export.targets import ExportRequest, fmu
from ident.identification.model import Model, rig_of
from recordings.errors import BadInput
from tests.ident.export.models import model_with
from tests.ident.export.targets.compilers import STRICT, need

RATE = 200.0


@pytest.fixture
def request_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ExportRequest:
    need("gcc")
    monkeypatch.setenv("CC", "gcc")
    model = model_with(["rod_inertia", "presliding_hysteresis", "temperature_friction", "backlash"])
    return ExportRequest(model, paths.from_trajectory("fig5b", rig_of(model.file), 1, RATE), tmp_path / "model.fmu")


def simulated(file: Path, path: paths.GivenPath, celsius: float) -> np.ndarray:
    """Torque (n, 3): after each step, that of the inputs before it."""
    import fmpy

    motion = path.motion
    signals = {"q": motion.position, "qd": motion.velocity, "qdd": motion.acceleration}
    columns = {f"{name}_{j + 1}": values[:, j] for name, values in signals.items() for j in range(3)}
    columns |= {f"temperature_{j}": np.full(len(path.time), celsius) for j in (1, 2, 3)}
    time = np.arange(len(path.time)) / RATE
    table = np.rec.fromarrays([time, *columns.values()], names=["time", *columns])
    outputs = ["tau_1", "tau_2", "tau_3"]
    result = fmpy.simulate_fmu(
        str(file), stop_time=time[-1], step_size=1 / RATE, output_interval=1 / RATE, input=table, output=outputs,
        fmi_type="CoSimulation",
    )  # fmt: skip
    return np.column_stack([result[name] for name in outputs])


def test_fmpy_validates_and_reproduces_the_torque(request_of: ExportRequest) -> None:
    from fmpy.validation import validate_fmu

    carried = fmu.write(request_of)
    assert set(carried.lost) == {"backlash"}
    assert validate_fmu(str(request_of.out)) == []
    path, model = request_of.path, request_of.model
    assert isinstance(path, paths.GivenPath)
    motion = (path.motion.position, path.motion.velocity, path.motion.acceleration)
    warm = np.full_like(motion[0], 45.0)
    terms = model.terms(*motion, 1 / RATE, path.time, warm)
    expected = sum(values for name, values in terms.items() if name != "backlash")
    np.testing.assert_allclose(simulated(request_of.out, path, 45.0)[1:], expected[:-1], atol=1e-9)


def test_the_wrapper_compiles_without_warnings(request_of: ExportRequest, tmp_path: Path) -> None:
    import subprocess
    from zipfile import ZipFile

    fmu.write(request_of)
    with ZipFile(request_of.out) as archive:
        archive.extractall(tmp_path / "fmu")
    words = ["gcc", *STRICT, "-c", "fmi2_delta_model.c", "-o", "wrapper.o"]
    done = subprocess.run(words, cwd=tmp_path / "fmu" / "sources", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_without_a_compiler_it_says_so(
    request_of: ExportRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(BadInput, match="a C compiler"):
        fmu.write(request_of)
    monkeypatch.setenv("CC", "false")
    with pytest.raises(BadInput, match="set \\$CC to another one"):
        fmu.write(request_of)
    assert not list(tmp_path.iterdir())


def test_single_precision_is_refused(request_of: ExportRequest) -> None:
    single = ExportRequest(request_of.model, request_of.path, request_of.out, "float")
    with pytest.raises(BadInput, match="double precision"):
        fmu.write(single)
    assert isinstance(single.model, Model)

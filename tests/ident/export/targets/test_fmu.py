"""FMPy accepts the FMU, and simulates what Python computes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.export import exporting, paths
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
    return ExportRequest(
        model,
        paths.from_trajectory("fig5b", rig_of(model.file), 1, RATE),
        tmp_path / "model.fmu",
        fmu.Settings(),
        "0",
    )


def simulated(file: Path, path: paths.GivenPath, celsius: float, kind: str) -> np.ndarray:
    """Torque (n, 3) of an FMU as FMPy simulates it."""
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
        fmi_type=kind, solver="Euler",
    )  # fmt: skip
    return np.column_stack([result[name] for name in outputs])


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_fmpy_validates_and_reproduces_the_torque(fmi: str, request_of: ExportRequest) -> None:
    """Model exchange gives the torque of the same sample; co-simulation, after each step, that of its beginning."""
    from fmpy.validation import validate_fmu

    carried = fmu.write(replace(request_of, settings=fmu.Settings(fmi=fmi)))  # type: ignore[arg-type]
    assert set(carried.lost) == {"backlash"}
    assert validate_fmu(str(request_of.out)) == []
    path, model = request_of.path, request_of.model
    motion = (path.motion.position, path.motion.velocity, path.motion.acceleration)
    warm = np.full_like(motion[0], 45.0)
    terms = model.terms(*motion, 1 / RATE, path.time, warm)
    expected = sum(values for name, values in terms.items() if name != "backlash")
    exchanged = simulated(request_of.out, path, 45.0, "ModelExchange")
    np.testing.assert_allclose(exchanged, expected, atol=1e-9)
    stepped = simulated(request_of.out, path, 45.0, "CoSimulation")
    np.testing.assert_allclose(stepped[1:], expected[:-1], atol=1e-9)


def plant_of(tmp_path: Path, fmi: str, smooth: float) -> tuple[Model, paths.GivenPath, Path]:
    need("gcc")
    model = model_with(["rod_inertia", "stribeck"])
    path, out = paths.from_trajectory("fig5a", rig_of(model.file), 1, 10_000.0), tmp_path / "plant.fmu"
    given = {"plant": "forward", "fmi": fmi, "smooth_velocity": smooth}
    exporting.export(model, "fmu", out, path, given=given)
    return model, path, out


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_forward_plant_moves_alike_in_model_exchange_and_co_simulation(fmi: str, tmp_path: Path) -> None:
    import fmpy
    from fmpy.validation import validate_fmu

    model, _, out = plant_of(tmp_path, fmi, 0.01)
    assert validate_fmu(str(out)) == []
    weight = model.torque(*np.zeros((3, 1, 3)))[0]
    push = {f"tau_{j}": weight[j - 1] + 3.0 * j for j in (1, 2, 3)}
    names = [f"{name}_{j}" for name in ("q", "qd") for j in (1, 2, 3)]
    ends = []
    for kind in ("ModelExchange", "CoSimulation"):
        result = fmpy.simulate_fmu(
            str(out), stop_time=0.1, output_interval=1e-3, start_values=push, output=names, fmi_type=kind,
            relative_tolerance=1e-8,
        )  # fmt: skip
        ends.append([result[name][-1] for name in names])
    assert np.abs(ends[0]).min() > 1e-4
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-5)


def test_forward_plant_follows_the_torque_of_the_inverse_model(tmp_path: Path) -> None:
    """With a PD of 400 N m/rad and 20 N m s/rad, in steps of 0.1 ms: within 1 mrad, below 1 % of the torque."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    model, path, out = plant_of(tmp_path, "2", 0.01)
    motion, rows = path.motion, 10_000
    direction = np.tanh(motion.velocity / 0.01)
    inputs = model.dynamics.inputs(replace(motion, direction=direction), 1e-4, path.time)
    torque = model.dynamics.torque(inputs)
    guid, folder = fmpy.read_model_description(str(out)).guid, fmpy.extract(str(out), str(tmp_path / "plant"))
    plant = FMU2Slave(guid=guid, unzipDirectory=folder, modelIdentifier=fmu.NAME, instanceName="plant")
    plant.instantiate()
    plant.setupExperiment(startTime=0.0)
    plant.setReal(range(3, 9), [*motion.position[0], *motion.velocity[0]])
    plant.enterInitializationMode()
    plant.exitInitializationMode()
    errors, pd = np.zeros((rows, 3)), np.zeros((rows, 3))
    for k in range(rows):
        state = np.array(plant.getReal(range(3, 9)))
        errors[k] = motion.position[k] - state[:3]
        pd[k] = 400.0 * errors[k] + 20.0 * (motion.velocity[k] - state[3:])
        plant.setReal(range(3), list(torque[k] + pd[k]))
        plant.doStep(path.time[k], 1e-4)
    plant.terminate()
    plant.freeInstance()
    assert np.abs(errors).max() < 1e-3
    assert np.sqrt((pd**2).mean()) < 0.01 * np.sqrt((torque[:rows] ** 2).mean())


def test_units_and_feed_through_are_declared(request_of: ExportRequest) -> None:
    import fmpy

    fmu.write(request_of)
    description = fmpy.read_model_description(str(request_of.out))
    units = {variable.name: variable.unit for variable in description.modelVariables}
    assert {units[f"{name}_1"] for name in ("q", "qd", "qdd", "tau", "temperature")} == {
        "rad", "rad/s", "rad/s2", "N.m", "degC",
    }  # fmt: skip
    assert {unit.name for unit in description.unitDefinitions} == set(units.values())
    for output in description.outputs:
        assert len(output.dependencies) == 12


@pytest.mark.parametrize("settings", [fmu.Settings(), fmu.Settings(fmi="3", plant="forward")])
def test_the_wrapper_compiles_without_warnings(
    settings: fmu.Settings, request_of: ExportRequest, tmp_path: Path
) -> None:
    import subprocess
    from zipfile import ZipFile

    fmu.write(replace(request_of, settings=settings))
    with ZipFile(request_of.out) as archive:
        archive.extractall(tmp_path / "fmu")
    words = ["gcc", *STRICT, "-c", f"fmi{settings.fmi}_delta_model.c", "-o", "wrapper.o"]
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

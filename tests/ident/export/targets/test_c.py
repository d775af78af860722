"""The C code gives the torque that Python gives, on random states and along motions."""

import ctypes
import json
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.dynamics.effects.library import library
from ident.dynamics.torque_map import voltage_from_torque
from ident.export import paths
from ident.export.c_source import code_of
from ident.export.targets import ExportRequest, c
from ident.identification.model import Model, rig_of
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis
from tests.ident.export.models import model_with
from tests.ident.export.targets.compilers import SANITIZERS, compile_c
from tests.ident.kept_models import MODELS

LIBRARY = library()
EXPORTABLE = [name for name, effect in LIBRARY.items() if code_of(effect)]
DELTA = [name for name in EXPORTABLE if "delta" in LIBRARY[name].mechanisms]
AXES = [name for name in EXPORTABLE if "axes" in LIBRARY[name].mechanisms]
BENCH = (Axis(), Axis(type="prismatic", gravity=True), Axis(gravity=True))
DT = 2e-3
ROWS = 10_000


@pytest.fixture(scope="module")
def delta() -> Model:
    return model_with(DELTA)


@pytest.fixture(scope="module")
def by_gcc(delta: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The delta robot, compiled once."""
    folder = export(delta, tmp_path_factory.mktemp("c"))
    return compiled(folder, "gcc")


def export(model: Model, folder: Path, precision: str = "double") -> Path:
    path = paths.from_trajectory("fig5a", rig_of(ident.load_model(MODELS / "lad.model.json").file), 1, 200.0)
    c.write(ExportRequest(model, path, folder, precision))  # type: ignore[arg-type]
    return folder


def compiled(folder: Path, compiler: str) -> Path:
    return compile_c(compiler, [folder / "delta_model.c"], folder / f"{compiler}.so", "-shared", "-fPIC")


class Stepped:
    """The compiled model."""

    def __init__(self, shared: Path, real: type[ctypes.c_double] | type[ctypes.c_float] = ctypes.c_double) -> None:
        self.code, self.real = ctypes.CDLL(str(shared)), real
        self.state = ctypes.create_string_buffer(4096)
        self.code.delta_model_init(self.state)

    def warm(self, celsius: list[float]) -> None:
        self.code.delta_model_temperature(self.state, (self.real * 3)(*celsius))

    def torque(self, q: Floats, qd: Floats, qdd: Floats, dt: float) -> Floats:
        result = np.empty_like(q)
        tau = (self.real * 3)()
        for k, row in enumerate(zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True)):
            arrays = [(self.real * 3)(*values) for values in row]
            self.code.delta_model_torque(self.state, *arrays, self.real(dt), tau)
            result[k] = list(tau)
        return result


def states(seed: int = 0) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.5, 0.5, (ROWS, 3)), rng.uniform(-4, 4, (ROWS, 3)), rng.uniform(-60, 60, (ROWS, 3))


def test_every_effect_without_code_in_c_has_a_reason_to_have_none() -> None:
    assert set(LIBRARY) - set(EXPORTABLE) == {
        "joint_elasticity", "backlash", "actuation_delay", "back_emf", "amplifier_deadband", "amplifier_saturation",
        "torque_gain_mismatch", "torque_map_exponent",
    }  # fmt: skip


@pytest.mark.parametrize("mechanism", ["delta", "axes"])
def test_c_equals_python_on_random_states(mechanism: str, delta: Model, by_gcc: Path, tmp_path: Path) -> None:
    model = delta if mechanism == "delta" else model_with(AXES, BENCH)
    stepped = Stepped(by_gcc if mechanism == "delta" else compiled(_export_axes(model, tmp_path), "clang"))
    stepped.warm([30.0, 40.0, 50.0])
    q, qd, qdd = states()
    expected = model.torque(q, qd, qdd, DT, DT * np.arange(ROWS), np.tile([30.0, 40.0, 50.0], (ROWS, 1)))
    np.testing.assert_allclose(stepped.torque(q, qd, qdd, DT), expected, atol=1e-12 * np.abs(expected).max(), rtol=0)


@pytest.mark.parametrize("mapping", ["square", "linear"])
def test_voltage_is_that_of_the_torque_map(mapping: str, delta: Model, tmp_path: Path) -> None:
    torque_map = delta.file.torque.model_copy(update={"map": mapping, "gain": (0.5, 1.0, 2.0)})
    model = replace(delta, file=delta.file.model_copy(update={"torque": torque_map}))
    code = Stepped(compiled(export(model, tmp_path), "gcc")).code
    torque = np.random.default_rng(0).uniform(-30, 30, (100, 3))
    for row, expected in zip(torque, voltage_from_torque(torque, torque_map), strict=True):
        volts = (ctypes.c_double * 3)()
        code.delta_model_voltage((ctypes.c_double * 3)(*row), volts)
        np.testing.assert_allclose(list(volts), expected, rtol=1e-14)


def _export_axes(model: Model, folder: Path) -> Path:
    time = np.arange(400) * DT
    q = np.sin(3 * time[:, None] + np.arange(3))
    motion = paths.Motion(q, 3 * np.cos(3 * time[:, None] + np.arange(3)), -9 * q, np.sign(q))
    c.write(ExportRequest(model, paths.GivenPath("swing", 1 / DT, time, motion), folder))
    return folder


def test_single_precision_is_close(delta: Model, tmp_path: Path) -> None:
    stepped = Stepped(compiled(export(delta, tmp_path, "float"), "gcc"), ctypes.c_float)
    q, qd, qdd = states()
    cold = np.full_like(q, 25.0)
    expected = delta.torque(q, qd, qdd, DT, DT * np.arange(ROWS), cold)
    np.testing.assert_allclose(stepped.torque(q, qd, qdd, DT), expected, atol=1e-4 * np.abs(expected).max(), rtol=0)


@pytest.mark.slow
@pytest.mark.parametrize(("compiler", "precision"), [("gcc", "float"), ("clang", "double")])
def test_the_example_finds_the_test_vectors_right_under_sanitizers(
    precision: str, compiler: str, delta: Model, tmp_path: Path
) -> None:
    export(delta, tmp_path, precision)
    sources = [tmp_path / "example.c", tmp_path / "delta_model.c"]
    program = compile_c(compiler, sources, tmp_path / "example", *SANITIZERS)
    done = subprocess.run([program, tmp_path / "test_vectors.csv"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith(f"{c.TEST_ROWS} rows")


def test_an_input_that_is_not_finite_gives_nan_and_leaves_no_trace(by_gcc: Path) -> None:
    q, qd, qdd = (signal[:3] for signal in states())
    gap = q.copy()
    gap[1, 2] = np.nan
    torque = Stepped(by_gcc).torque(gap, qd, qdd, DT)
    assert np.isnan(torque[1]).all()
    assert np.isfinite(torque[[0, 2]]).all()


def test_out_of_reach_is_nan(by_gcc: Path) -> None:
    stepped = Stepped(by_gcc)
    far = np.array([[-3.0, 0.1, 0.1]])
    assert np.isnan(stepped.torque(far, 0 * far, 0 * far, DT)).all()


def test_what_is_not_carried_is_missing_in_the_test_vectors(tmp_path: Path) -> None:
    model = ident.load_model(MODELS / "stateful.model.json")
    path = paths.from_trajectory("fig5a", rig_of(model.file), 1, 200.0)
    carried = c.write(ExportRequest(model, path, tmp_path))
    assert carried.lost == {"joint_elasticity": "no code in C"}
    from ident.export import losses

    losses.write(model, carried, path, tmp_path / "carried.json", "c")
    document = json.loads((tmp_path / "carried.json").read_text())
    (entry,) = document["not_carried"]
    assert entry["effect"] == "joint_elasticity"
    assert 0 < min(entry["torque_lost_rms"]) < max(document["torque_rms"])
    assert entry["torque_lost_rms"] == document["torque_lost_rms"]
    rigid = c.vectors(model, path, carried)
    assert not {name for name in rigid if name.startswith("joint_elasticity")}


def test_alternative_forms_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="form 'lagrange14' found"):
        export(ident.load_model(MODELS / "rls.model.json"), tmp_path)

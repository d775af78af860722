"""The C code gives the torque that Python gives, on random states and along motions."""

import ctypes
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.dynamics.effects.library import library
from ident.dynamics.torque_map import voltage_from_torque
from ident.export import exporting, paths
from ident.export.c_source import CSettings, code_of
from ident.export.targets import c
from ident.identification.model import Model, rig_of
from ident.identification.model_file import MotionRange
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis
from tests.ident.export.models import model_with
from tests.ident.export.targets.compilers import SANITIZERS, Stepped, compile_c, compiled
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
    return compiled(export(delta, tmp_path_factory.mktemp("c")))


def export(model: Model, folder: Path, precision: str = "double", **settings: object) -> Path:
    path = paths.from_trajectory("fig5a", rig_of(ident.load_model(MODELS / "lad.model.json").file), 1, 200.0)
    exporting.export(model, "c", folder, path.at_temperature(40.0), precision, settings)  # type: ignore[arg-type]
    return folder


def states(seed: int = 0) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.5, 0.5, (ROWS, 3)), rng.uniform(-4, 4, (ROWS, 3)), rng.uniform(-60, 60, (ROWS, 3))


def test_every_effect_without_code_in_c_has_a_reason_to_have_none() -> None:
    assert set(LIBRARY) - set(EXPORTABLE) == {
        "joint_elasticity", "backlash", "actuation_delay", "back_emf", "amplifier_deadband", "amplifier_saturation",
        "torque_gain_mismatch", "torque_map_exponent", "self_heating",
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
    code = Stepped(compiled(export(model, tmp_path))).code
    torque = np.random.default_rng(0).uniform(-30, 30, (100, 3))
    for row, expected in zip(torque, voltage_from_torque(torque, torque_map), strict=True):
        volts = (ctypes.c_double * 3)()
        code.delta_model_voltage((ctypes.c_double * 3)(*row), volts)
        np.testing.assert_allclose(list(volts), expected, rtol=1e-14)


def _export_axes(model: Model, folder: Path) -> Path:
    time = np.arange(400) * DT
    q = np.sin(3 * time[:, None] + np.arange(3))
    motion = paths.Motion(q, 3 * np.cos(3 * time[:, None] + np.arange(3)), -9 * q, np.sign(q))
    path = paths.GivenPath("swing", 1 / DT, time, motion).at_temperature(40.0)
    exporting.export(model, "c", folder, path)
    return folder


def test_single_precision_is_close(delta: Model, tmp_path: Path) -> None:
    stepped = Stepped(compiled(export(delta, tmp_path, "float")), ctypes.c_float)
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


def test_what_is_not_carried_is_missing_in_the_test_vectors(tmp_path: Path) -> None:
    model = ident.load_model(MODELS / "stateful.model.json")
    path = paths.from_trajectory("fig5a", rig_of(model.file), 1, 200.0)
    carried = exporting.export(model, "c", tmp_path, path)
    assert carried.lost == {"joint_elasticity": "no code in C"}
    rigid = c.vectors(model, path, carried, CSettings())
    assert not {name for name in rigid if name.startswith("joint_elasticity")}


def test_alternative_forms_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="form 'lagrange14' found"):
        export(ident.load_model(MODELS / "rls.model.json"), tmp_path)


def reals(*values: float) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * 3)(*values)


@pytest.mark.parametrize(
    ("angle", "dt"), [(np.nan, DT), (-3.0, DT), (0.1, np.nan), (0.1, np.inf), (0.1, -1e-3)], ids=str
)
def test_what_cannot_be_computed_gives_nan_and_leaves_no_trace(angle: float, dt: float, by_gcc: Path) -> None:
    q, qd, qdd = (signal[:6] for signal in states())
    stepped, disturbed = Stepped(by_gcc), Stepped(by_gcc)
    expected = stepped.torque(q, qd, qdd, DT)
    first = disturbed.torque(q[:3], qd[:3], qdd[:3], DT)
    wrong = np.array([[angle, 0.1, 0.1]])
    assert np.isnan(disturbed.torque(wrong, qd[:1], qdd[:1], dt)).all()
    after = disturbed.torque(q[3:], qd[3:], qdd[3:], DT)
    assert np.isfinite(after).all()
    if dt != DT:  # else time has passed, on which some effects depend
        np.testing.assert_array_equal(np.concatenate([first, after]), expected)


def test_residual_is_the_measured_torque_without_the_models(by_gcc: Path) -> None:
    q, qd, qdd = (signal[:5] for signal in states())
    torque, stepped = Stepped(by_gcc).torque(q, qd, qdd, DT), Stepped(by_gcc)
    for k in range(5):
        left = reals()
        motion = (reals(*q[k]), reals(*qd[k]), reals(*qdd[k]))
        stepped.code.delta_model_residual(stepped.state, *motion, ctypes.c_double(DT), reals(1, 2, 3), left)
        np.testing.assert_array_equal(list(left), np.array([1.0, 2.0, 3.0]) - torque[k])


def accelerations(stepped: Stepped, q: Floats, qd: Floats, torque: Floats) -> Floats:
    result = np.empty_like(q)
    for k in range(len(q)):
        qdd = reals()
        given = (reals(*q[k]), reals(*qd[k]), reals(*torque[k]), ctypes.c_double(DT))
        stepped.code.delta_model_acceleration(stepped.state, *given, qdd)
        result[k] = list(qdd)
    return result


@pytest.mark.parametrize("smooth", [0.0, 0.02])
def test_acceleration_is_the_inverse_of_the_torque(smooth: float, delta: Model, tmp_path: Path) -> None:
    shared = compiled(export(delta, tmp_path, smooth_velocity=smooth))
    q, qd, qdd = (signal[:300] for signal in states())
    torque = Stepped(shared).torque(q, qd, qdd, DT)
    np.testing.assert_allclose(accelerations(Stepped(shared), q, qd, torque), qdd, atol=1e-7)


def test_at_standstill_friction_holds_up_to_its_limit(tmp_path: Path) -> None:
    """Each joint rests within its friction, or moves in the direction against which its friction is then."""
    model = model_with(["rod_inertia", "load_dependent_friction", "stribeck"])
    stepped = Stepped(compiled(export(model, tmp_path)))
    q, rest = states()[0][:400], np.zeros((400, 3))
    weight = model.torque(q, rest, rest, DT)
    push = np.random.default_rng(1).uniform(-20, 20, (400, 3))
    push[0] = 0.0
    qdd = accelerations(stepped, q, rest, weight + push)
    assert (qdd[0] == 0).all()
    held = qdd == 0
    assert 0.1 < held.mean() < 0.9
    slow = 1e-9 * np.sign(qdd)  # friction of the joints that begin to move; those at rest take what is left
    left = weight + push - model.torque(q, slow, qdd, DT)
    np.testing.assert_allclose(left[~held], 0, atol=1e-6)
    limits = [model.torque(q, slow + 1e-9 * sign * held, qdd, DT) - (weight + push - left) for sign in (-1, 1)]
    assert ((limits[0] - 1e-6 < left) & (left < limits[1] + 1e-6))[held].all()


def test_smooth_velocity_takes_the_step_out_of_friction(delta: Model, tmp_path: Path) -> None:
    shared = compiled(export(delta, tmp_path, smooth_velocity=0.01))
    q, slow = np.zeros((1, 3)), np.full((1, 3), 1e-9)
    jump = Stepped(shared).torque(q, slow, 0 * q, DT) - Stepped(shared).torque(q, -slow, 0 * q, DT)
    assert np.abs(jump).max() < 1e-5
    with pytest.raises(BadInput, match=r"a speed of 0 or more expected, -1 found"):
        export(delta, tmp_path, smooth_velocity=-1)


def test_range_is_that_of_the_fit(delta: Model, by_gcc: Path, tmp_path: Path) -> None:
    motion = MotionRange(position=((-0.5, 0.5),) * 3, velocity=((-4, 4),) * 3, acceleration=((-60, 60),) * 3)
    known = replace(delta, file=delta.file.model_copy(update={"motion_range": motion}))
    code = Stepped(compiled(export(known, tmp_path))).code
    assert code.delta_model_in_range(reals(0.5, 0, 0), reals(0, -4, 0), reals(0, 0, 60))
    outside = [
        (reals(0.51, 0, 0), reals(), reals()),
        (reals(), reals(0, 4.1, 0), reals()),
        (reals(), reals(), reals(0, 0, np.nan)),
    ]
    assert not any(code.delta_model_in_range(*each) for each in outside)
    assert not Stepped(by_gcc).code.delta_model_in_range(reals(), reals(), reals())  # an old file: not known

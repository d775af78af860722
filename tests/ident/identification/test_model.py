"""An identified model as an object, and its prediction of the torque of recordings."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ident
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.estimation import estimators
from ident.identification.identify import FitOptions, identify
from ident.identification.model import Model, rig_of
from ident.identification.model_file import ModelFile
from ident.identification.prediction import predict, structure_of
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Geometry, Torque, simulated_rig
from tests.ident.export.models import model_with
from tests.ident.kept_models import MODELS

TIME = np.arange(200) / 200
Q = np.stack([0.2 * np.sin(3 * TIME + shift) for shift in (0.0, 2.1, 4.2)], axis=1)
QD = np.gradient(Q, TIME, axis=0)
QDD = np.gradient(QD, TIME, axis=0)


@pytest.fixture(scope="module")
def model(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Model:
    """Fitted to a recording that follows Eq. (26) exactly."""
    file = write(make(cycles=2, path=tmp_path_factory.mktemp("model") / "a.mcap"))
    return ident.fit([file], method="lad")


def test_fitted_torque_is_that_of_the_true_parameters(model: Model, truth: Floats) -> None:
    expected = mechanisms.create(simulated_rig()).regressor(Motion(Q, QD, QDD, np.sign(QD))) @ truth
    np.testing.assert_allclose(model.torque(Q, QD, QDD), expected, rtol=0.02, atol=0.1)
    voltage = model.voltage(Q, QD, QDD)  # through the torque map
    np.testing.assert_allclose(voltage * np.abs(voltage), model.torque(Q, QD, QDD), atol=1e-9)


def test_inertia_is_symmetric_positive_definite_and_the_torque_per_acceleration(model: Model) -> None:
    inertia = model.inertia(Q)
    np.testing.assert_allclose(inertia, inertia.swapaxes(1, 2), atol=1e-9)
    assert (np.linalg.eigvalsh(inertia) > 0).all()
    more = model.torque(Q, QD, QDD + np.array([0.0, 1.0, 0.0])) - model.torque(Q, QD, QDD)
    np.testing.assert_allclose(inertia[:, :, 1], more, atol=1e-9)


def test_saved_and_loaded_it_gives_the_same_torque(model: Model, tmp_path: Path) -> None:
    model.save(tmp_path / "m.json")
    loaded = ident.load_model(tmp_path / "m.json")
    assert loaded.parameters == model.parameters
    np.testing.assert_array_equal(loaded.torque(Q, QD, QDD), model.torque(Q, QD, QDD))


def test_effects_in_place_of_friction_are_saved_without_the_parameters_that_they_replace(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    file = write(make(cycles=2, rate=250.0, path=tmp_path / "a.mcap"))
    effects = ["power_law_friction:2", "position_dependent_friction:1"]
    fitted = ident.fit([file], method="ls", effects=effects)
    fitted.save(tmp_path / "m.json")
    loaded = ident.load_model(tmp_path / "m.json")
    assert {"c_v1", "c_c2"} < set(loaded.parameters)
    assert not {"c_v2", "c_c1"} & set(loaded.parameters)
    np.testing.assert_array_equal(loaded.torque(Q, QD, QDD), fitted.torque(Q, QD, QDD))
    assert np.isfinite(loaded.inertia(Q)).all()


@pytest.mark.parametrize("name", ["stribeck", "signal", "stateful", "rls", "lad", "diagnosed", "slide"])
def test_model_files_give_torque(name: str) -> None:
    loaded = ident.load_model(MODELS / f"{name}.model.json")
    dof = len(loaded.file.joints)
    torque = loaded.torque(Q[:, :dof], QD[:, :dof], QDD[:, :dof], dt=TIME[1], t=TIME)
    assert torque.shape == (len(TIME), dof)
    assert np.isfinite(torque).all()


@pytest.mark.parametrize(
    ("arrays", "options", "reason"),
    [
        ((Q[:, :2], QD[:, :2], QDD[:, :2]), {}, r"shape \(n, 3\) expected"),
        ((Q, QD, QDD), {"t": TIME[:5]}, "one value per instant"),
        ((Q, QD, QDD), {"dt": 0.0}, "dt, a time step above 0 s"),
    ],
)
def test_what_is_no_motion_is_refused(
    model: Model, arrays: tuple[Any, ...], options: dict[str, Any], reason: str
) -> None:
    with pytest.raises(BadInput, match=reason):
        model.torque(*arrays, **options)
    with pytest.raises(TypeError, match="qd: an array of real numbers expected"):
        model.torque(Q, "fast", QDD)


def test_a_recording_is_not_replaced(model: Model, tmp_path: Path) -> None:
    recording = tmp_path / "a.mcap"
    recording.write_bytes(b"a recording")
    with pytest.raises(BadInput, match="a model's name expected"):
        model.save(recording)
    assert recording.read_bytes() == b"a recording"
    with pytest.raises(BadInput, match="cannot be written"):
        model.save(tmp_path / "nothing" / "m.json")


def test_what_exists_is_replaced_only_if_asked(model: Model, tmp_path: Path) -> None:
    mine = tmp_path / "m.json"
    mine.write_text("mine")
    for write in (model.save, lambda path, **options: model.export("c", path, **options)):
        with pytest.raises(BadInput, match=r"a new name expected, .* exists; give another one, or force=True"):
            write(mine)
    assert mine.read_text() == "mine"
    model.save(mine, force=True)
    assert ident.load_model(mine).effects == model.effects


@pytest.fixture(scope="module")
def file(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    return write(make(cycles=1, noise=0.01, path=tmp_path_factory.mktemp("p") / "a.mcap"))


@pytest.fixture(
    scope="module",
    params=[(), ("torque_offset",), ("stribeck:1,2",), ("torque_gain_mismatch:1", "presliding_hysteresis")],
)
def identified(file: Path, request: pytest.FixtureRequest) -> ModelFile:
    options = FitOptions("ls", estimators.settings("ls", {}), 0, "parallel", 20.0, request.param)
    return identify([file], (), options, lambda *_: None).model


def test_the_model_explains_its_own_recording(identified: ModelFile, file: Path) -> None:
    (prediction,) = predict(identified, [file], library())
    assert prediction.prepared.bandwidth == 20
    rms = np.sqrt(np.nanmean(prediction.residual**2, axis=0))
    np.testing.assert_allclose(rms, identified.train.fitted.rms, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"geometry": Geometry(L2=0.81)}, r"geometry\.L2 is 0\.8 in the model, 0\.81"),
        ({"torque": Torque(map="linear")}, r"torque\.map is square in the model, linear"),
    ],
)
def test_a_recording_of_another_rig_is_refused(
    identified: ModelFile,
    make: Callable[..., Recording],
    write: Callable[[Recording], Path],
    tmp_path: Path,
    change: dict[str, object],
    message: str,
) -> None:
    changed = simulated_rig().model_copy(update=change)
    path = write(make(cycles=1, rig=changed, path=tmp_path / "other.mcap"))
    with pytest.raises(BadInput, match=f"{message} in other.mcap; fit a model to it"):
        predict(identified, [path], library())


def test_unknown_parameters_are_refused(identified: ModelFile, file: Path) -> None:
    with pytest.raises(BadInput, match=r"m_p, .* expected in the model, T_g, .* fit it again"):
        predict(identified.model_copy(update={"parameters": identified.parameters[1:]}), [file], library())


def test_every_joint_has_its_own_shapes() -> None:
    model = model_with(["position_dependent_friction"])
    assert sorted(model.file.terms[0].shapes) == ["high1", "high3", "low1", "low3"]
    _, x = structure_of(model.file, rig_of(model.file), library())
    np.testing.assert_array_equal(x, model.dynamics.values)

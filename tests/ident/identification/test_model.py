"""An identified model as an object."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
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
    folder = tmp_path_factory.mktemp("model")
    files = [write(make(cycles=2, path=folder / "a.mcap"))]
    return ident.fit(files, method="lad")


def test_fitted_torque_is_that_of_the_true_parameters(model: Model, truth: Floats) -> None:
    from ident.dynamics import mechanisms
    from ident.dynamics.motion import Motion
    from recordings.rig import simulated_rig

    expected = mechanisms.create(simulated_rig()).regressor(Motion(Q, QD, QDD, np.sign(QD))) @ truth
    np.testing.assert_allclose(model.torque(Q, QD, QDD), expected, rtol=0.02, atol=0.1)


def test_voltage_gives_the_torque_through_the_torque_map(model: Model) -> None:
    voltage = model.voltage(Q, QD, QDD)
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


def test_arrays_of_other_shapes_are_refused(model: Model) -> None:
    with pytest.raises(BadInput, match=r"shape \(n, 3\) expected"):
        model.torque(Q[:, :2], QD[:, :2], QDD[:, :2])
    with pytest.raises(BadInput, match="one value per instant"):
        model.torque(Q, QD, QDD, t=TIME[:5])


def test_what_is_no_array_or_no_time_step_is_refused(model: Model, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="qd: an array of real numbers expected"):
        model.torque(Q, "fast", QDD)
    with pytest.raises(BadInput, match="dt, a time step above 0 s"):
        model.torque(Q, QD, QDD, dt=0.0)
    with pytest.raises(BadInput, match="cannot be written"):
        model.save(tmp_path / "nothing" / "m.json")


def test_a_recording_is_not_replaced(model: Model, tmp_path: Path) -> None:
    recording = tmp_path / "a.mcap"
    recording.write_bytes(b"a recording")
    with pytest.raises(BadInput, match="a model's name expected"):
        model.save(recording)
    assert recording.read_bytes() == b"a recording"

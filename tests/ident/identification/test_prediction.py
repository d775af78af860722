"""Prediction of the torque of recordings by a model file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from ident.estimation import estimators
from ident.identification.identify import FitOptions, identify
from ident.identification.model import rig_of
from ident.identification.model_file import ModelFile
from ident.identification.prediction import predict, structure_of
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.rig import Geometry, Torque, simulated_rig
from tests.ident.export.models import model_with


@pytest.fixture(scope="module")
def file(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    return write(make(cycles=1, noise=0.01, path=tmp_path_factory.mktemp("p") / "a.mcap"))


@pytest.fixture(
    scope="module",
    params=[(), ("torque_offset",), ("stribeck:1,2",), ("torque_gain_mismatch:1", "presliding_hysteresis")],
)
def model(file: Path, request: pytest.FixtureRequest) -> ModelFile:
    options = FitOptions("ls", estimators.settings("ls", {}), 0, "parallel", 20.0, request.param)
    return identify([file], None, options, lambda *_: None).model


def test_the_model_explains_its_own_recording(model: ModelFile, file: Path) -> None:
    (prediction,) = predict(model, [file], library())
    assert prediction.prepared.bandwidth == 20
    rms = np.sqrt(np.nanmean(prediction.residual**2, axis=0))
    np.testing.assert_allclose(rms, model.train.fitted.rms, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"geometry": Geometry(L2=0.81)}, r"geometry\.L2 is 0\.8 in the model, 0\.81"),
        ({"torque": Torque(map="linear")}, r"torque\.map is square in the model, linear"),
    ],
)
def test_a_recording_of_another_rig_is_refused(
    model: ModelFile,
    make: Callable[..., Recording],
    write: Callable[[Recording], Path],
    tmp_path: Path,
    change: dict[str, object],
    message: str,
) -> None:
    changed = simulated_rig().model_copy(update=change)
    path = write(make(cycles=1, rig=changed, path=tmp_path / "other.mcap"))
    with pytest.raises(BadInput, match=f"{message} in other.mcap; fit a model to it"):
        predict(model, [path], library())


def test_unknown_parameters_are_refused(model: ModelFile, file: Path) -> None:
    with pytest.raises(BadInput, match=r"m_p, .* expected in the model, T_g, .* fit it again"):
        predict(model.model_copy(update={"parameters": model.parameters[1:]}), [file], library())


def test_shapes_of_an_earlier_file_are_those_of_every_joint() -> None:
    model = model_with(["position_dependent_friction"])
    assert sorted(model.file.terms[0].shapes) == ["high1", "high3", "low1", "low3"]
    structure, x = structure_of(model.file, rig_of(model.file), library())
    np.testing.assert_array_equal(x, model.dynamics.values)
    (term,) = model.file.terms
    earlier = model.file.model_copy(
        update={"terms": (term.model_copy(update={"shapes": {"low": -0.5, "high": 0.7}}),)}
    )
    _, shared = structure_of(earlier, rig_of(model.file), library())
    np.testing.assert_array_equal(structure.shape_values(0, shared), [-0.5, 0.7, -0.5, 0.7])

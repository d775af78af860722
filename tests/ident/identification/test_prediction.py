"""Prediction of the torque of recordings by a model file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from ident.estimation import estimators
from ident.identification.identify import FitOptions, identify
from ident.identification.model_file import ModelFile
from ident.identification.prediction import predict
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.rig import Geometry, Torque, simulated_rig


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

"""A real arm of six joints, where its data are: our first step beside plain least squares, written with Pinocchio."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.data.prepared_recording import PreparedRecording, _in_blocks
from ident.data.row_weights import moving_or_all, standstill_share
from ident.dynamics.motion import Motion
from ident.identification.model import Model
from ident.identification.prediction import predict
from recordings.importing import Description, import_data
from recordings.recording import Floats
from recordings.rig import load_rig

pinocchio = pytest.importorskip("pinocchio")
DATA = Path(os.environ.get("REAL_DATA", Path(__file__).parents[3].parent / "shared" / "data")) / "kuka_kr300"
RIG = f"""name = "KR300"
mechanism = "urdf"
urdf = "{DATA / "kr300.urdf"}"
joints = [{", ".join(f'"joint_{i}"' for i in range(1, 7))}]
"""

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not DATA.is_dir(), reason="the data are not here")]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Sequence[Path]:
    folder = tmp_path_factory.mktemp("arm")
    (folder / "rig.toml").write_text(RIG, encoding="utf-8")
    description = Description(rig=load_rig(folder / "rig.toml", driven=False))
    paths = [folder / f"{name}.mcap" for name in "abc"]
    for path in paths:
        import_data(DATA / f"trajectory_{path.stem}.csv", path, description)
    return paths


class Baseline:
    """Base parameters of the links, viscous and Coulomb friction, offset and motor inertia, by least squares.

    Each joint is weighted by its own residual.
    """

    def __init__(self, train: PreparedRecording) -> None:
        self.model = pinocchio.buildModelFromUrdf(str(DATA / "kr300.urdf"))
        states = np.random.default_rng(5).uniform(-2, 2, (3, 200, 6))
        columns = self._physical(Motion(*states, np.sign(states[1]))).reshape(1200, -1)
        self.independent = self._independent(columns)
        rows = moving_or_all(train, standstill_share(train))
        regressor, deviation = self.regressor(train), np.ones(6)
        for _ in range(30):
            weighted, torque = (regressor / deviation[:, None])[rows], (train.torque / deviation)[rows]
            size = np.linalg.norm(weighted, axis=0)
            self.parameters = np.linalg.lstsq(weighted / size, torque, rcond=None)[0] / size
            deviation = rms(np.where(rows, train.torque - regressor @ self.parameters, np.nan))

    def residual(self, prepared: PreparedRecording) -> Floats:
        residual: Floats = prepared.torque - self.regressor(prepared) @ self.parameters
        return residual

    def regressor(self, prepared: PreparedRecording) -> Floats:
        return _in_blocks(prepared.preprocessed, lambda motion: self._physical(motion)[:, :, self.independent])

    def _physical(self, motion: Motion) -> Floats:
        data = self.model.createData()
        signals = (motion.position, motion.velocity, motion.acceleration)
        links = [
            pinocchio.computeJointTorqueRegressor(self.model, data, *at).copy()
            for at in zip(*map(np.nan_to_num, signals), strict=True)
        ]
        joints = (motion.acceleration, motion.velocity, motion.direction, np.ones_like(motion.velocity))
        return np.concatenate([np.array(links), *(signal[:, :, None] * np.eye(6) for signal in joints)], axis=2)

    @staticmethod
    def _independent(columns: Floats) -> list[int]:
        """The rank of the leading columns grows with each of these."""
        kept: list[int] = []
        for column in range(columns.shape[1]):
            candidate = columns[:, [*kept, column]]
            size = np.linalg.norm(candidate, axis=0)
            if size[-1] > 1e-9 and np.linalg.svd(candidate / size, compute_uv=False)[-1] > 1e-7:
                kept.append(column)
        return kept


def rms(residual: Floats) -> Floats:
    result: Floats = np.sqrt(np.nanmean(residual**2, axis=0))
    return result


@pytest.fixture(scope="module")
def model(recordings: Sequence[Path]) -> Model:
    return ident.fit([recordings[0]], method="wls")


def test_first_step_is_no_worse_than_plain_least_squares(recordings: Sequence[Path], model: Model) -> None:
    assert model.identification is not None
    baseline = Baseline(model.identification.train[0].prepared)
    for prediction in predict(model.file, recordings[1:], model.library):
        ours, theirs = rms(prediction.residual), rms(baseline.residual(prediction.prepared))
        assert (ours <= 1.02 * theirs).all(), (prediction.prepared.recording.path.name, ours / theirs)

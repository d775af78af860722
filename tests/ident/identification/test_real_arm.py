"""Real arms, where their data are: our first step beside plain least squares, written with Pinocchio."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.basics import slicing
from ident.data.prepared_recording import PreparedRecording, _in_blocks
from ident.data.row_weights import moving_or_all, standstill_share
from ident.dynamics.motion import Motion
from ident.identification.prediction import predict
from recordings.importing import Description, import_data
from recordings.reader import read
from recordings.recording import Floats, Recording
from recordings.rig import load_rig

pinocchio = pytest.importorskip("pinocchio")
DATA = Path(os.environ.get("REAL_DATA", Path(__file__).parents[3].parent / "shared" / "data"))
RIG = """name = "arm"
mechanism = "urdf"
urdf = "{urdf}"
joints = {joints}
"""
TRAIN = 0.6
"""Share of a single recording that trains."""

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not DATA.is_dir(), reason="the data are not here")]


def imported(urdf: Path, joints: Sequence[str], tables: Sequence[Path], folder: Path) -> list[Recording]:
    (folder / "rig.toml").write_text(RIG.format(urdf=urdf, joints=json.dumps(list(joints))), encoding="utf-8")
    description = Description(rig=load_rig(folder / "rig.toml", driven=False))
    for table in tables:
        import_data(table, folder / f"{table.stem}.mcap", description)
    return [read(folder / f"{table.stem}.mcap") for table in tables]


def kuka(folder: Path) -> tuple[Path, list[Recording]]:
    """Six joints; identified on the first motion, held out on two others."""
    data = DATA / "kuka_kr300"
    tables = [data / f"trajectory_{name}.csv" for name in "abc"]
    return data / "kr300.urdf", imported(data / "kr300.urdf", [f"joint_{i}" for i in range(1, 7)], tables, folder)


def pendulum(folder: Path) -> tuple[Path, list[Recording]]:
    """Two joints; the end of one recording is held out."""
    data = DATA / "double_pendulum"
    (whole,) = imported(data / "arm.urdf", ("shoulder", "elbow"), [data / "A0_long75s.csv"], folder)
    train = whole.time - whole.time[0] < TRAIN * np.ptp(whole.time)
    return data / "arm.urdf", [slicing.along_time(whole, rows) for rows in (train, ~train)]


class Baseline:
    """Base parameters of the links, viscous and Coulomb friction, offset and motor inertia, by least squares.

    Each joint is weighted by its own residual.
    """

    def __init__(self, urdf: Path, train: PreparedRecording) -> None:
        # Of a joint without limits, Pinocchio would want cosine and sine.
        limits = '"revolute"><limit lower="-100" upper="100" effort="1" velocity="1"/>'
        text = urdf.read_text(encoding="utf-8").replace('"continuous">', limits)
        self.model, dof = pinocchio.buildModelFromXML(text), train.torque.shape[1]
        position, velocity, acceleration = np.random.default_rng(5).uniform(-2, 2, (3, 200, dof))
        motion = Motion(position, velocity, acceleration, np.sign(velocity))
        columns = self._physical(motion).reshape(200 * dof, -1)
        self.independent = self._independent(columns)
        rows = moving_or_all(train, standstill_share(train))
        regressor, deviation = self.regressor(train), np.ones(dof)
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
        each = np.eye(motion.position.shape[1])
        return np.concatenate([np.array(links), *(signal[:, :, None] * each for signal in joints)], axis=2)

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


@pytest.mark.parametrize(("arm", "gained"), [(kuka, 0.85), (pendulum, 1.0)])
def test_first_step_is_no_worse_than_plain_least_squares(
    arm: Callable[[Path], tuple[Path, list[Recording]]], gained: float, tmp_path: Path
) -> None:
    """Links that stay bodies tell another motion better, but not every joint of it."""
    urdf, (train, *held_out) = arm(tmp_path)
    model = ident.fit([train], method="wls")
    assert model.identification is not None
    baseline = Baseline(urdf, model.identification.train[0].prepared)
    for prediction in predict(model.file, held_out, model.library):
        ours, theirs = rms(prediction.residual), rms(baseline.residual(prediction.prepared))
        assert (ours <= 1.05 * theirs).all(), (prediction.prepared.recording.path.name, ours / theirs)
        assert np.exp(np.mean(np.log(ours / theirs))) <= 1.01 * gained
